//! Objects of the contacts that are drawn: cylinders, and how large they may be for all that is known.

use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use super::known::{OFFSET_M, UNIFORM};

/// Radius of a cylinder of 120 mm, metre.
const LARGE_M: f64 = 0.060;

/// What is touched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Objects {
    /// Any radius from 1 to 50 mm, even in the logarithm of the radius plus 3 mm.
    Usual,
    /// Cylinders of 120 mm, of which it is known that their radius is one from 1 to 100 mm, which is what the library assumes.
    Large,
}

impl Objects {
    /// Least and largest radius for all that is known, metre.
    #[must_use]
    pub const fn radii_m(self) -> [f64; 2] {
        match self {
            Self::Usual => [0.001, 0.05],
            Self::Large => [0.001, 0.1],
        }
    }

    /// Ends of the logarithm that is even.
    fn logarithms(self) -> [f64; 2] {
        self.radii_m().map(|radius_m| (radius_m + OFFSET_M).ln())
    }

    /// Deviation of that logarithm.
    pub(super) fn sigma(self) -> f64 {
        let [least, most] = self.logarithms();
        UNIFORM * (most - least)
    }

    /// The radius of a contact, metre.
    pub(super) fn drawn_m(self, random: &mut Pcg64Mcg) -> f64 {
        match self {
            Self::Usual => {
                let [least, most] = self.logarithms();
                random.random_range(least..most).exp() - OFFSET_M
            }
            Self::Large => LARGE_M,
        }
    }
}
