//! What the curve of a contact tells of the object's own stiffness (docs/MECHANICS.md#soft-objects).

/// Deviations by which a value must stand clear of another to be told from it.
const CLEAR: f32 = 2.0;
/// Share of the rotation from which the object gives way more than the finger.
const HALF: f32 = 0.5;

/// How far an object gives way under the finger.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Object {
    /// Compliance at the contact and its standard deviation, metre per newton, >= 0.
    pub compliance_m_per_n: [f32; 2],
    /// Share of the input link's rotation since contact that is the object's, 0 to 1, and its standard deviation.
    pub share: [f32; 2],
}

/// Which gives way more, object or finger.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Relative {
    /// The object is stiffer than the finger: less than half of the rotation is its.
    Stiffer,
    /// The object is softer than the finger.
    Softer,
    /// The curve does not tell.
    Unclear,
}

impl Object {
    /// Stiffness, newton per metre; `None` where the compliance is not clear of zero, and nothing but
    /// [`Object::least_n_per_m`] is observable.
    pub fn stiffness_n_per_m(&self) -> Option<f32> {
        let [compliance, sigma] = self.compliance_m_per_n;
        (compliance > CLEAR * sigma).then(|| 1.0 / compliance)
    }

    /// The object is at least as stiff, newton per metre, two deviations.
    pub fn least_n_per_m(&self) -> f32 {
        let [compliance, sigma] = self.compliance_m_per_n;
        1.0 / (compliance + CLEAR * sigma)
    }

    /// Its stiffness compared with the finger's at the contact.
    pub fn relative(&self) -> Relative {
        let [share, sigma] = self.share;
        if share - CLEAR * sigma > HALF {
            Relative::Softer
        } else if share + CLEAR * sigma < HALF {
            Relative::Stiffer
        } else {
            Relative::Unclear
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stiffness_is_told_where_it_is_clear_of_a_rigid_object() {
        let object = |compliance_m_per_n, share| Object {
            compliance_m_per_n,
            share,
        };
        let soft = object([2e-3, 0.25e-3], [0.7, 0.09]);
        let told = soft.stiffness_n_per_m().expect("clear of zero");
        assert!((told - 500.0).abs() < 1e-3);
        assert!((soft.least_n_per_m() - 400.0).abs() < 1e-3);
        assert_eq!(soft.relative(), Relative::Softer);
        let stiff = object([1e-4, 0.2e-3], [0.05, 0.1]);
        assert_eq!(stiff.stiffness_n_per_m(), None);
        assert!((stiff.least_n_per_m() - 2000.0).abs() < 1e-2);
        assert_eq!(stiff.relative(), Relative::Stiffer);
        let between = object([1e-3, 0.3e-3], [0.5, 0.2]);
        assert_eq!(between.relative(), Relative::Unclear);
        assert_eq!(
            object([f32::NAN; 2], [f32::NAN; 2]).relative(),
            Relative::Unclear
        );
    }
}
