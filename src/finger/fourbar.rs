//! One four-bar stage: ground g from O_(i-1) to O_i, driving lever a at O_(i-1), coupler b, driven lever c at O_i.

use super::error::{check_range, try_const};
use super::{ConfigError, Parameter};
use crate::numeric::{Bounded, Rotation, constant_sqrt, sqrt};
use core::f32::consts::PI;

/// Limits of a lever's length, in the unit of the finger's lengths.
const LEVER_RANGE: [f32; 2] = [1e-6, 1e6];
/// How far the coupler must stay from stretched and folded, as a share of a + b: nearer the transmission factor has no
/// digit left in f32.
const DEAD_POINT_MARGIN: f32 = 1e-5;

/// On which side of the line from O_(i-1) to the coupler's far end the driving lever lies (the sign before acos in
/// docs/MECHANICS.md#transmission): the two ways to put a four-bar together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Assembly {
    /// Clockwise from the line, mode -1.
    Clockwise,
    /// Counterclockwise from the line, mode +1.
    Counterclockwise,
}

impl Assembly {
    const fn sign(self) -> f32 {
        match self {
            Self::Clockwise => -1.0,
            Self::Counterclockwise => 1.0,
        }
    }
}

/// Levers of one stage; lengths in metre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Levers {
    /// Driving lever a.
    pub driving_m: f32,
    /// Coupler b.
    pub coupler_m: f32,
    /// Driven lever c.
    pub driven_m: f32,
    /// Offset psi of the driven lever from its phalanx, radian, positive dorsal.
    pub offset_rad: f32,
    /// How it is put together.
    pub assembly: Assembly,
}

/// A stage checked to close.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FourBar {
    ground: f32,
    levers: Levers,
    offset: Rotation,
    /// Tip of the driving lever where v = 0: F counts from there.
    zero: [f32; 2],
}

/// Transmission of one stage in one posture: F(v) and its derivatives, without the angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ratio {
    /// F' = h / (h + g), with h the distance from O_i to where coupler line and ground line meet
    /// (docs/MECHANICS.md#transmission).
    pub first: f32,
    /// F''.
    pub second: f32,
    /// F'''.
    pub third: f32,
}

/// What a step of the driven lever does at the driving one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Advance {
    /// Half the rotation of the driving lever.
    pub half: Rotation,
    /// Change of F'.
    pub first_change: f32,
}

/// The driven lever of a stage, as in [`Pose`].
#[derive(Clone, Copy, Debug)]
struct Driven {
    b: [f32; 2],
    c: [f32; 2],
    delta: Rotation,
    square: f32,
}

/// Where the stage's points are, origin O_(i-1), first axis along the ground.
#[derive(Clone, Copy, Debug)]
struct Pose {
    /// Tip A of the driving lever.
    a: [f32; 2],
    /// Tip B of the driven lever.
    b: [f32; 2],
    /// B seen from O_i, and its direction.
    c: [f32; 2],
    delta: Rotation,
    /// cross(A, B), signed twice the area of O A B; zero in the dead points.
    area: f32,
    /// |B|^2.
    square: f32,
    /// A . B.
    along: f32,
}

const fn cross(u: [f32; 2], v: [f32; 2]) -> f32 {
    u[0] * v[1] - u[1] * v[0]
}

const fn dot(u: [f32; 2], v: [f32; 2]) -> f32 {
    u[0] * v[0] + u[1] * v[1]
}

impl FourBar {
    /// Its levers.
    pub fn levers(&self) -> Levers {
        self.levers
    }

    /// Checks the levers of a stage on a ground of given length, for all `v` in `range`.
    ///
    /// # Errors
    /// A lever outside its range, or a `v` at which the coupler does not reach: then the distance of its ends from
    /// O_(i-1) is named, which must lie between |a - b| and a + b.
    pub const fn build(
        stage: u8,
        ground_m: f32,
        levers: Levers,
        range: [f32; 2],
    ) -> Result<Self, ConfigError> {
        let [min, max] = LEVER_RANGE;
        let a = try_const!(check_range(
            Parameter::DrivingLever { stage },
            levers.driving_m,
            min,
            max
        ));
        let b = try_const!(check_range(
            Parameter::Coupler { stage },
            levers.coupler_m,
            min,
            max
        ));
        let c = try_const!(check_range(
            Parameter::DrivenLever { stage },
            levers.driven_m,
            min,
            max
        ));
        let psi = try_const!(check_range(
            Parameter::LeverOffset { stage },
            levers.offset_rad,
            -PI,
            PI
        ));
        let margin = DEAD_POINT_MARGIN * (a + b);
        let (nearest, farthest) = ((a - b).abs() + margin, a + b - margin);
        let [low, high] = range;
        let [least, most] = cosine_range([low.min(0.0) - psi, high.max(0.0) - psi]);
        let closure = Parameter::Closure { stage };
        try_const!(check_range(
            closure,
            reach(ground_m, c, least),
            nearest,
            farthest
        ));
        try_const!(check_range(
            closure,
            reach(ground_m, c, most),
            nearest,
            farthest
        ));
        let mut stage = Self {
            ground: ground_m,
            levers,
            offset: Rotation::by(psi).back(),
            zero: [0.0; 2],
        };
        stage.zero = stage.constant_pose(Rotation::NONE).a;
        Ok(stage)
    }

    /// Two circles intersected by two square roots: no arc function (docs/MECHANICS.md#transmission). Where they do
    /// not meet, the dead point.
    fn pose(&self, v: Rotation) -> Pose {
        let driven = self.driven(v);
        let heron = self.heron(sqrt(driven.square));
        self.closed(driven, sqrt(heron.at_least(0.0)))
    }

    /// The same with roots for the compiler: a stage is built as a constant.
    const fn constant_pose(&self, v: Rotation) -> Pose {
        let driven = self.driven(v);
        let heron = self.heron(constant_sqrt(driven.square));
        self.closed(driven, constant_sqrt(heron))
    }

    /// The driven lever.
    #[inline(always)]
    const fn driven(&self, v: Rotation) -> Driven {
        let (c, ground) = (self.levers.driven_m, self.ground);
        let delta = v.then(self.offset);
        let c_tip = [c * delta.cos, c * delta.sin];
        Driven {
            b: [ground + c_tip[0], c_tip[1]],
            c: c_tip,
            delta,
            square: (ground * ground + c * c) + 2.0 * (ground * c) * delta.cos,
        }
    }

    /// Sixteen times the square of the area of O A B, whose sides are a, b and the coupler's `reach` |B|.
    #[inline(always)]
    const fn heron(&self, reach: f32) -> f32 {
        let (a, b) = (self.levers.driving_m, self.levers.coupler_m);
        // Heron's factors: near the dead points their product keeps the digits that R^2 a^2 - p^2 would lose.
        ((b - a) + reach) * ((a - b) + reach) * ((a - reach) + b) * ((a + reach) + b)
    }

    /// The stage put together, from its driven lever and the root of [`Self::heron`].
    #[inline(always)]
    const fn closed(&self, driven: Driven, root: f32) -> Pose {
        let (a, b) = (self.levers.driving_m, self.levers.coupler_m);
        let Driven {
            b: b_tip,
            c: c_tip,
            delta,
            square,
        } = driven;
        let half_area = 0.5 * self.levers.assembly.sign() * root;
        let along = 0.5 * (square + (a - b) * (a + b));
        let a_tip = [
            (along * b_tip[0] - half_area * b_tip[1]) / square,
            (along * b_tip[1] + half_area * b_tip[0]) / square,
        ];
        Pose {
            a: a_tip,
            b: b_tip,
            c: c_tip,
            delta,
            area: -half_area,
            square,
            along,
        }
    }

    /// Derivatives of F at the angle of `v`; `None` in a dead point or beyond.
    pub fn ratio(&self, v: Rotation) -> Option<Ratio> {
        let Pose {
            a,
            c,
            delta,
            area,
            square,
            along,
            ..
        } = self.pose(v);
        let g = self.ground;
        // F' from the triangle O A B alone: how B turns about O, and how the angle at O follows |B|. The tips' positions
        // would bring in their roundings, and k depends on F' more than on anything else.
        let (driven, both) = (self.levers.driven_m, g * self.levers.driven_m);
        let turn = driven * driven + both * delta.cos;
        let first = (turn - both * delta.sin * ((square - along) / area)) / square;
        // The tips move along the coupler at the same rate: F' cross(A, B) = cross(C, B - A); the higher derivatives
        // follow by differentiating both sides, with A turning at F' and C at 1.
        let (lean, twist) = (dot(c, a), cross(c, a));
        let slip = 1.0 - first;
        let (driven_1, area_1) = (lean * slip - g * c[0], lean * slip - first * g * a[0]);
        let second = (driven_1 - first * area_1) / area;
        let common = twist * slip * slip - lean * second;
        let (driven_2, area_2) = (
            common + g * c[1],
            common - second * g * a[0] + first * first * g * a[1],
        );
        let third = (driven_2 - 2.0 * second * area_1 - first * area_2) / area;
        (first.is_finite() && second.is_finite() && third.is_finite()).then_some(Ratio {
            first,
            second,
            third,
        })
    }

    /// h, the signed distance from O_i to the intersection of ground line and coupler line, metre; `None` where they are
    /// parallel.
    pub fn intersection_m(&self, v: Rotation) -> Option<f32> {
        let Pose { a, c, area, .. } = self.pose(v);
        let driven = -self.ground * c[1] - cross(c, a);
        let h = self.ground * driven / (area - driven);
        h.is_finite().then_some(h)
    }

    /// Rotation of the driving lever from v = 0.
    pub fn lever(&self, v: Rotation) -> Rotation {
        self.turned(&self.pose(v))
    }

    /// The same for the compiler.
    pub(crate) const fn constant_lever(&self, v: Rotation) -> Rotation {
        self.turned(&self.constant_pose(v))
    }

    #[inline(always)]
    const fn turned(&self, to: &Pose) -> Rotation {
        let a = to.a;
        let square = self.levers.driving_m * self.levers.driving_m;
        Rotation {
            cos: dot(self.zero, a) / square,
            sin: cross(self.zero, a) / square,
        }
    }

    /// What happens at the driving lever while the driven one turns on from `v` by twice `half`; `None` where the stage
    /// cannot follow or starts in a dead point.
    ///
    /// From |B - A| staying b: an exact quadratic in the tangent of half the rotation, whose terms are all formed from
    /// the chord of the driven lever's tip, never as a difference of two positions.
    pub fn advance(&self, v: Rotation, half: Rotation) -> Option<Advance> {
        let Pose { a, b, c, area, .. } = self.pose(v);
        let db = chord(c, half);
        let b_new = [b[0] + db[0], b[1] + db[1]];
        let (p, q) = (cross(a, b_new), dot(a, b_new));
        let e = dot([b[0] - a[0] + 0.5 * db[0], b[1] - a[1] + 0.5 * db[1]], db);
        // (e + 2 q) t^2 - 2 p t + e = 0, the root that vanishes with e.
        let root = p * p - e * (e + 2.0 * q);
        // A negative root gives NaN, which the last line refuses.
        let t = e / (p + sqrt(root).copysign(area));
        let cos = 1.0 / sqrt(1.0 + t * t);
        let lever = Rotation { cos, sin: t * cos };

        // The changes of F' = driven / area, numerator and denominator of `ratio`, by the product rule.
        let da = chord(a, lever);
        let driven = -self.ground * c[1] - cross(c, a);
        let driven_change = -self.ground * db[1] - cross(db, a) - cross(c, da) - cross(db, da);
        let area_change = cross(da, b) + cross(a, db) + cross(da, db);
        let first_change = (driven_change - driven / area * area_change) / (area + area_change);
        (t.is_finite() && first_change.is_finite()).then_some(Advance {
            half: lever,
            first_change,
        })
    }
}

/// By what a vector changes as it turns by twice `half`: perpendicular to its middle direction.
fn chord(of: [f32; 2], half: Rotation) -> [f32; 2] {
    let middle = [
        of[0] * half.cos - of[1] * half.sin,
        of[1] * half.cos + of[0] * half.sin,
    ];
    [-2.0 * half.sin * middle[1], 2.0 * half.sin * middle[0]]
}

/// Distance of the coupler's far end from O_(i-1).
const fn reach(ground: f32, driven: f32, cosine: f32) -> f32 {
    constant_sqrt(ground * ground + driven * driven + 2.0 * ground * driven * cosine)
}

/// Least and largest cosine over an interval of angles within +-4 pi.
const fn cosine_range([low, high]: [f32; 2]) -> [f32; 2] {
    let (from, to) = (Rotation::by(low).cos, Rotation::by(high).cos);
    let [mut least, mut most] = [from.min(to), from.max(to)];
    let mut half_turns = -4;
    while half_turns <= 5 {
        let angle = half_turns as f32 * PI;
        if low <= angle && angle <= high {
            if half_turns % 2 == 0 {
                most = 1.0;
            } else {
                least = -1.0;
            }
        }
        half_turns += 1;
    }
    [least, most]
}
