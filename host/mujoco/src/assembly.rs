//! Assembly of a four-bar from the intersection of two circles.

use palpate_plant::FingerParameters;

/// One stage: ground from joint i-1 to joint i, driving lever at joint i-1, coupler, driven lever on the next phalanx.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stage {
    pub ground: f64,
    pub lever: f64,
    pub coupler: f64,
    pub driven: f64,
    /// Angle from the phalanx back to its driven lever.
    pub offset: f64,
    /// 1: the driving lever lies counterclockwise of the line to the driven lever's tip.
    pub mode: f64,
}

/// Angles of a closed stage against the ground link, radian.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Closed {
    /// Of the driving lever.
    pub lever: f64,
    /// Of the coupler, from the driving lever's tip.
    pub coupler: f64,
}

impl Stage {
    /// Stage `i` from 0 of a finger; `None` for one driven by a tendon.
    pub fn of(finger: &FingerParameters, i: usize) -> Option<Self> {
        Some(Self {
            ground: *finger.length_m.get(i)?,
            lever: *finger.lever_m.get(i)?,
            coupler: *finger.coupler_m.get(i)?,
            driven: *finger.driven_m.get(i)?,
            offset: finger.offset_deg.get(i)?.to_radians(),
            mode: *finger.mode.get(i)?,
        })
    }

    /// The driven lever's tip in the frame of its phalanx.
    pub fn tip(&self) -> [f64; 2] {
        let (sin, cos) = self.offset.sin_cos();
        [self.driven * cos, -self.driven * sin]
    }

    /// Closes the loop at a joint angle; `None` where it does not close.
    pub fn close(&self, joint: f64) -> Option<Closed> {
        let (sin, cos) = (joint - self.offset).sin_cos();
        let tip = [self.ground + self.driven * cos, self.driven * sin];
        let reach = tip[0].hypot(tip[1]);
        let cosine = (reach * reach + self.lever * self.lever - self.coupler * self.coupler)
            / (2.0 * self.lever * reach);
        if !(-1.0..=1.0).contains(&cosine) {
            return None;
        }
        let lever = tip[1].atan2(tip[0]) + self.mode * cosine.acos();
        let (sin, cos) = lever.sin_cos();
        let coupler = (tip[1] - self.lever * sin).atan2(tip[0] - self.lever * cos);
        Some(Closed { lever, coupler })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_loop_closes() {
        let parameters = palpate_plant::Parameters::default();
        let finger = &parameters.finger;
        let stage = Stage::of(finger, 0).expect("a linkage");
        for joint in [0.0, 0.3, 1.2, 2.0] {
            let closed = stage.close(joint).expect("within the joint's range");
            let (sin, cos) = (joint - stage.offset).sin_cos();
            let by_lever = [
                stage.lever * closed.lever.cos() + stage.coupler * closed.coupler.cos(),
                stage.lever * closed.lever.sin() + stage.coupler * closed.coupler.sin(),
            ];
            let by_joint = [stage.ground + stage.driven * cos, stage.driven * sin];
            for axis in 0..2 {
                assert!((by_lever[axis] - by_joint[axis]).abs() < 1e-12);
            }
        }
    }
}
