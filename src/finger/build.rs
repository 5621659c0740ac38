//! A finger and its validated construction.

use super::error::{check_range, try_const};
use super::{
    ConfigError, Configuration, Direct, Levers, Linkage, Mounting, Parameter, ReturnCable, Tendon,
    Transmission, Weight,
};
use core::f32::consts::PI;

/// Limits of a phalanx's length: any unit from kilometre to micrometre.
const LENGTH_RANGE: [f32; 2] = [1e-6, 1e6];
/// Limits of a spring's stiffness: beyond, products of two leave the range of f32.
pub(super) const STIFFNESS_RANGE: [f32; 2] = [1e-9, 1e9];

/// Geometry and springs of a finger of N phalanges. A configuration: plain numbers, checked by [`Finger::new`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters<const N: usize> {
    /// Lengths l_i of the phalanges, proximal first, metre.
    pub lengths_m: [f32; N],
    /// Stiffnesses K_i of the joints' springs, newton metre per radian. The first may be 0: joint 1 without a spring.
    pub stiffness_nm_per_rad: [f32; N],
    /// Rest angles of the springs, radian.
    pub rest_rad: [f32; N],
    /// Opening and closing stop of each joint, radian; the transmission must work between them.
    pub range_rad: [[f32; 2]; N],
}

impl<const N: usize> Parameters<N> {
    /// Refuses what is not finite or outside its range; without a spring at joint 1, K_1 is 0, with a return cable all are.
    pub(super) const fn check(&self, base: Base) -> Result<(), ConfigError> {
        let (mut i, mut joint) = (0, 1);
        while i < N {
            let [min, max] = LENGTH_RANGE;
            let length = Parameter::Length { phalanx: joint };
            try_const!(check_range(length, self.lengths_m[i], min, max));
            let (stiffness, [min, max]) = (self.stiffness_nm_per_rad[i], STIFFNESS_RANGE);
            let spring = Parameter::Stiffness { joint };
            let without = match base {
                Base::Any => false,
                Base::Springless => joint == 1,
                Base::ReturnCable => true,
            };
            if without {
                try_const!(check_range(spring, stiffness, 0.0, 0.0));
            } else if !(joint == 1 && stiffness == 0.0) {
                try_const!(check_range(spring, stiffness, min, max));
            }
            let [low, high] = self.range_rad[i];
            let [upper, lower] = [
                Parameter::UpperStop { joint },
                Parameter::LowerStop { joint },
            ];
            try_const!(check_range(upper, high, -2.0 * PI, 2.0 * PI));
            try_const!(check_range(lower, low, -2.0 * PI, high));
            let rest = Parameter::RestAngle { joint };
            try_const!(check_range(rest, self.rest_rad[i], low, high));
            (i, joint) = (i + 1, joint + 1);
        }
        Ok(())
    }
}

/// What is known of the spring at joint 1 before the finger is: a scene carries only the equations that it needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Base {
    /// Its stiffness is asked; 0 is none.
    Any,
    /// None: nothing but a contact holds the input link, and joint 1 follows it while the others rest.
    Springless,
    /// None at any joint: a preloaded cable opens the finger, and joint 1 follows the input link while joint 2 stands at its stop
    /// ([`ReturnCable`]).
    ReturnCable,
}

/// A [`Base`] as a type.
pub trait BaseJoint: Copy + core::fmt::Debug {
    /// Which.
    const BASE: Base;

    /// The first phalanx that can touch anything.
    const FIRST_TOUCHING: u8 = 1;

    /// Whether something holds joint 2 at its stop until a contact has raised the torque by a break-away torque
    /// (docs/FINGERS.md#break-away).
    const HOLDS: bool = false;

    /// Returns whether the joints beyond the first stand at their stops until a contact: without a spring at joint 1, or with a return
    /// cable. `stiffness` is that of each joint's spring, joint 1 first, in any unit.
    fn stands_at_stops(stiffness: &[f32]) -> bool {
        !matches!(Self::BASE, Base::Any) || stiffness.first() == Some(&0.0)
    }

    /// Whether the weight of the phalanges is stated.
    const WEIGHS: bool = false;

    /// See [`Mechanics::PINS_LEAVE`](super::Mechanics::PINS_LEAVE).
    const PINS_LEAVE: f32 = 1.0;

    /// What opens the finger in place of springs.
    fn return_cable(&self) -> Option<&ReturnCable> {
        None
    }

    /// Torque with which the spring of joint 2 holds it at its stop, newton metre.
    fn preload_nm(&self) -> Option<f32> {
        None
    }

    /// The weight of the phalanges where it is stated ([`Weighted`](super::Weighted)).
    fn weight(&self) -> Option<&Weight> {
        None
    }

    /// The same in another mounting; nothing changes without a weight.
    #[must_use]
    fn mounted(self, mounting: Mounting) -> Self {
        let _ = mounting;
        self
    }
}

/// A base that the type tells all of.
pub trait KnownBase: BaseJoint {
    /// Its one value.
    const KNOWN: Self;
}

/// [`Base::Any`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AnyBase;

impl BaseJoint for AnyBase {
    const BASE: Base = Base::Any;
}

impl KnownBase for AnyBase {
    const KNOWN: Self = Self;
}

/// [`Base::Springless`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Springless;

impl BaseJoint for Springless {
    const BASE: Base = Base::Springless;
}

impl KnownBase for Springless {
    const KNOWN: Self = Self;
}

/// [`Base::Springless`] with a spring at joint 2 that is preloaded against its stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Preloaded {
    torque_nm: f32,
}

impl BaseJoint for Preloaded {
    const BASE: Base = Base::Springless;
    const HOLDS: bool = true;

    fn preload_nm(&self) -> Option<f32> {
        Some(self.torque_nm)
    }
}

/// A base whose phalanx lies within the palm and touches nothing: its joint gives way to a contact anywhere on the next phalanx,
/// whose place then changes the stiffness as well (docs/FINGERS.md#hidden-phalanx).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HiddenBase<B>(B);

impl<B: KnownBase> BaseJoint for HiddenBase<B> {
    const BASE: Base = B::BASE;
    const FIRST_TOUCHING: u8 = 2;
}

impl<B: KnownBase> KnownBase for HiddenBase<B> {
    const KNOWN: Self = Self(B::KNOWN);
}

/// A finger: immutable once built.
///
/// ```
/// use palpate::finger::{Finger, Mechanics, Parameters, Tendon};
///
/// let parameters = Parameters {
///     lengths_m: [0.080, 0.060],
///     stiffness_nm_per_rad: [0.1, 0.1],
///     rest_rad: [0.3, 0.3],
///     range_rad: [[-0.5, 2.5], [0.0, 2.0]],
/// };
/// let finger = Finger::<2, Tendon<2>>::new(parameters, [0.012, 0.008])?;
/// assert_eq!(finger.phalanx_length_m(2), Some(0.060));
///
/// let negative = Parameters { lengths_m: [0.080, -0.060], ..parameters };
/// let error = Finger::<2, Tendon<2>>::new(negative, [0.012, 0.008]).unwrap_err();
/// println!("{error}"); // names parameter, value and range
/// # Ok::<(), palpate::finger::ConfigError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finger<const N: usize, T, B = AnyBase> {
    pub(crate) parameters: Parameters<N>,
    pub(crate) transmission: T,
    pub(crate) rest: Configuration<N>,
    pub(crate) base: B,
}

impl<const N: usize, T: Transmission<N>> Finger<N, T> {
    /// Checks parameters and transmission, limits included.
    ///
    /// # Errors
    /// The first parameter that is not finite or outside its range: a length (1e-6 to 1e6), a stiffness (1e-9 to 1e9, or
    /// 0 at joint 1), stops (within +-2 pi, in order), a rest angle (between its stops), or what the transmission
    /// rejects.
    pub fn new(parameters: Parameters<N>, design: T::Design) -> Result<Self, ConfigError> {
        parameters.check(Base::Any)?;
        Self::assembled(parameters, T::build(design, &parameters)?, AnyBase)
    }
}

/// Fingers as constants: what [`Finger::new`] checks is checked by the compiler, and the firmware carries the result.
macro_rules! constant {
    ($phalanges:literal, $transmission:ty, $design:ty, |$given:ident, $parameters:ident| $of:expr) => {
        impl<B: KnownBase> Finger<$phalanges, $transmission, B> {
            /// As [`Finger::new`], for a constant.
            ///
            /// # Errors
            /// Those of [`Finger::new`]; also a spring at joint 1 where the type says that there is none.
            pub const fn constant(
                $parameters: Parameters<$phalanges>,
                $given: $design,
            ) -> Result<Self, ConfigError> {
                try_const!($parameters.check(B::BASE));
                Self::assembled($parameters, try_const!($of), B::KNOWN)
            }
        }
    };
}

constant!(2, Tendon<2>, [f32; 2], |radii, parameters| Tendon::<2>::of(
    radii
));
constant!(3, Tendon<3>, [f32; 4], |radii, parameters| Tendon::<3>::of(
    radii
));
constant!(4, Tendon<4>, [f32; 6], |radii, parameters| Tendon::<4>::of(
    radii
));
constant!(5, Tendon<5>, [f32; 8], |radii, parameters| Tendon::<5>::of(
    radii
));
constant!(
    6,
    Tendon<6>,
    [f32; 10],
    |radii, parameters| Tendon::<6>::of(radii)
);
constant!(
    2,
    Direct<2>,
    (),
    |_nothing, parameters| Ok::<_, ConfigError>(Direct)
);
constant!(
    3,
    Direct<3>,
    (),
    |_nothing, parameters| Ok::<_, ConfigError>(Direct)
);
constant!(2, Linkage<1>, [Levers; 1], |levers, parameters| {
    Linkage::<1>::of(levers, &parameters)
});
constant!(3, Linkage<2>, [Levers; 2], |levers, parameters| {
    Linkage::<2>::of(levers, &parameters)
});
constant!(4, Linkage<3>, [Levers; 3], |levers, parameters| {
    Linkage::<3>::of(levers, &parameters)
});
constant!(5, Linkage<4>, [Levers; 4], |levers, parameters| {
    Linkage::<4>::of(levers, &parameters)
});
constant!(6, Linkage<5>, [Levers; 5], |levers, parameters| {
    Linkage::<5>::of(levers, &parameters)
});

impl<T: Transmission<2>> Finger<2, T, Springless> {
    /// The same finger with the spring of joint 2 preloaded against its stop, where it rests, by a torque, newton metre.
    ///
    /// # Errors
    /// A torque that is not within 1e-9 and 1e9; a joint 2 that does not rest at its stop.
    pub const fn preloaded(self, torque_nm: f32) -> Result<Finger<2, T, Preloaded>, ConfigError> {
        let Self {
            parameters,
            transmission,
            ..
        } = self;
        let [min, max] = STIFFNESS_RANGE;
        try_const!(check_range(Parameter::Preload, torque_nm, min, max));
        let ([_, [stop, _]], [_, rest]) = (parameters.range_rad, parameters.rest_rad);
        try_const!(check_range(
            Parameter::RestAngle { joint: 2 },
            rest,
            stop,
            stop
        ));
        Finger::assembled(parameters, transmission, Preloaded { torque_nm })
    }
}

impl Finger<2, Tendon<2>, ReturnCable> {
    /// A finger that a return cable opens, from its parameters, the radii r_1 and r_2 of the closing tendon, and that cable.
    ///
    /// # Errors
    /// Those of [`Finger::new`]; a spring at any joint; a joint that does not rest at its opening stop; a cable's torque or stiffness
    /// that is not within 1e-9 and 1e9, or a ratio of its pulleys that does not exceed r_2 / r_1: joint 2 would not stay at its stop.
    pub const fn returned(
        parameters: Parameters<2>,
        radii_m: [f32; 2],
        cable: ReturnCable,
    ) -> Result<Self, ConfigError> {
        try_const!(parameters.check(Base::ReturnCable));
        let (mut i, mut joint) = (0, 1);
        while i < 2 {
            let [stop, _] = parameters.range_rad[i];
            let rest = Parameter::RestAngle { joint };
            try_const!(check_range(rest, parameters.rest_rad[i], stop, stop));
            (i, joint) = (i + 1, joint + 1);
        }
        let tendon = try_const!(Tendon::<2>::of(radii_m));
        let cable = try_const!(cable.check(radii_m[1] / radii_m[0]));
        Self::assembled(parameters, tendon, cable)
    }
}

impl<const N: usize, T: Copy, B: BaseJoint> Finger<N, T, B> {
    /// Puts together what was checked.
    pub(super) const fn assembled(
        parameters: Parameters<N>,
        transmission: T,
        base: B,
    ) -> Result<Self, ConfigError> {
        let rest = try_const!(posture(parameters.rest_rad));
        Ok(Self {
            parameters,
            transmission,
            rest,
            base,
        })
    }

    /// Nothing but a contact holds the input link.
    pub(crate) fn springless(&self) -> bool {
        !matches!(B::BASE, Base::ReturnCable) && self.stands_at_stops()
    }

    /// The joints beyond the first stand at their stops until a contact.
    pub(crate) fn stands_at_stops(&self) -> bool {
        B::stands_at_stops(&self.parameters.stiffness_nm_per_rad)
    }

    /// What the finger was built from.
    pub fn parameters(&self) -> &Parameters<N> {
        &self.parameters
    }

    /// The transmission.
    pub fn transmission(&self) -> &T {
        &self.transmission
    }

    /// A posture from joint angles, radian.
    ///
    /// # Errors
    /// An angle that is not finite or beyond its stops.
    pub fn configuration(&self, rad: [f32; N]) -> Result<Configuration<N>, ConfigError> {
        for (i, joint) in (0..N).zip(1u8..) {
            let [low, high] = self.parameters.range_rad[i];
            check_range(Parameter::JointAngle { joint }, rad[i], low, high)?;
        }
        posture(rad)
    }
}

/// A posture of angles within some stops: they lie within two turns.
const fn posture<const N: usize>(rad: [f32; N]) -> Result<Configuration<N>, ConfigError> {
    match Configuration::of(rad) {
        Some(posture) => Ok(posture),
        None => Err(ConfigError {
            parameter: Parameter::JointAngle { joint: 1 },
            value: rad[0],
            min: -4.0 * PI,
            max: 4.0 * PI,
        }),
    }
}
