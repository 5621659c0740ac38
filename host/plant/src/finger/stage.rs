//! One stage of the transmission.

use crate::linkage::Fourbar;

/// One stage of the transmission, joint angle to the lever before it.
#[derive(Clone, Debug)]
pub(super) enum Stage {
    Tendon {
        ratio: f64,
    },
    Linkage {
        fourbar: Fourbar,
        zero: f64,
        gamma: f64,
    },
}

impl Stage {
    /// F and F' at a joint angle; a linkage follows on from its last position.
    pub fn at(&mut self, angle: f64) -> (f64, f64) {
        match self {
            Self::Tendon { ratio } => (*ratio * angle, *ratio),
            Self::Linkage {
                fourbar,
                zero,
                gamma,
            } => {
                let slope;
                (*gamma, slope) = fourbar.follow(*gamma, angle);
                (*gamma - *zero, slope)
            }
        }
    }
}
