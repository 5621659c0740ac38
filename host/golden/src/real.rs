//! Numbers of about 77 digits.

use std::cell::RefCell;
use std::cmp::Ordering;
use std::ops::{Add, Div, Mul, Neg, Sub};

use astro_float_num::{BigFloat, Consts, Radix, RoundingMode};

/// Bits of the mantissa: derivatives are differences over a step of 2^-60, a second one loses 120 bits of them.
const PRECISION: usize = 256;
const ROUNDING: RoundingMode = RoundingMode::ToEven;

thread_local! {
    static CONSTANTS: RefCell<Consts> = RefCell::new(Consts::new().expect("memory for pi"));
}

/// A real number; results are rounded to the working precision.
#[derive(Clone, Debug)]
pub struct Real(BigFloat);

impl Real {
    /// Zero.
    #[must_use]
    pub fn zero() -> Self {
        Self::from(0.0)
    }

    /// One.
    #[must_use]
    pub fn one() -> Self {
        Self::from(1.0)
    }

    /// Two to the power of `exponent`.
    #[must_use]
    pub fn power_of_two(exponent: i32) -> Self {
        Self::from(f64::from(exponent).exp2())
    }

    /// Square root; not a number below 0.
    #[must_use]
    pub fn sqrt(&self) -> Self {
        Self(self.0.sqrt(PRECISION, ROUNDING))
    }

    /// Sine and cosine.
    #[must_use]
    pub fn sin_cos(&self) -> (Self, Self) {
        CONSTANTS.with_borrow_mut(|constants| {
            let sine = self.0.sin(PRECISION, ROUNDING, constants);
            (Self(sine), Self(self.0.cos(PRECISION, ROUNDING, constants)))
        })
    }

    /// Arc cosine; not a number beyond 1.
    #[must_use]
    pub fn acos(&self) -> Self {
        CONSTANTS.with_borrow_mut(|constants| Self(self.0.acos(PRECISION, ROUNDING, constants)))
    }

    /// Angle of the point (x, y), from -pi to pi.
    #[must_use]
    pub fn atan2(y: &Self, x: &Self) -> Self {
        let length = (x * x + y * y).sqrt();
        let angle = (x / &length).acos();
        if y.is_negative() { -angle } else { angle }
    }

    /// Magnitude.
    #[must_use]
    pub fn abs(&self) -> Self {
        Self(self.0.abs())
    }

    /// Below zero.
    #[must_use]
    pub fn is_negative(&self) -> bool {
        self.0.is_negative() && !self.0.is_zero()
    }

    /// Above zero.
    #[must_use]
    pub fn is_positive(&self) -> bool {
        self.0.is_positive() && !self.0.is_zero()
    }

    /// Zero.
    #[must_use]
    pub fn is_zero(&self) -> bool {
        self.0.is_zero()
    }

    /// Not a number, for instance where a linkage does not close.
    #[must_use]
    pub fn is_nan(&self) -> bool {
        self.0.is_nan()
    }

    /// The nearest f64.
    #[must_use]
    pub fn to_f64(&self) -> f64 {
        if self.0.is_nan() {
            return f64::NAN;
        }
        let text =
            CONSTANTS.with_borrow_mut(|constants| self.0.format(Radix::Dec, ROUNDING, constants));
        text.ok()
            .and_then(|text| text.parse().ok())
            .unwrap_or(f64::NAN)
    }
}

impl From<f64> for Real {
    fn from(value: f64) -> Self {
        Self(BigFloat::from_f64(value, PRECISION))
    }
}

impl PartialEq for Real {
    fn eq(&self, other: &Self) -> bool {
        self.partial_cmp(other) == Some(Ordering::Equal)
    }
}

impl PartialOrd for Real {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        self.0.cmp(&other.0).map(|sign| sign.cmp(&0))
    }
}

impl Neg for Real {
    type Output = Self;

    fn neg(self) -> Self {
        Self(self.0.neg())
    }
}

macro_rules! operator {
    ($name:ident, $function:ident) => {
        impl $name<&Real> for &Real {
            type Output = Real;

            fn $function(self, other: &Real) -> Real {
                Real(self.0.$function(&other.0, PRECISION, ROUNDING))
            }
        }

        impl $name<Real> for &Real {
            type Output = Real;

            fn $function(self, other: Real) -> Real {
                self.$function(&other)
            }
        }

        impl $name<&Real> for Real {
            type Output = Real;

            fn $function(self, other: &Real) -> Real {
                (&self).$function(other)
            }
        }

        impl $name<Real> for Real {
            type Output = Real;

            fn $function(self, other: Real) -> Real {
                (&self).$function(&other)
            }
        }
    };
}

operator!(Add, add);
operator!(Sub, sub);
operator!(Mul, mul);
operator!(Div, div);

#[cfg(test)]
mod tests {
    use super::Real;

    #[test]
    fn functions_agree_with_each_other_to_many_digits() {
        let angle = Real::from(0.7);
        let (sine, cosine) = angle.sin_cos();
        let off = (&sine * &sine + &cosine * &cosine - Real::one()).abs();
        assert!(off < Real::power_of_two(-240));
        let back = Real::atan2(&-sine, &cosine) + angle;
        assert!(back.abs() < Real::power_of_two(-240));
        assert_eq!(Real::from(0.1).to_f64(), 0.1);
        assert!(Real::from(1.5).acos().is_nan());
    }
}
