//! Objects, and their distance from a phalanx.

use crate::Error;

/// Position or direction in the plane of the finger, metre: x along phalanx 1 at theta_1 = 0, y to its palm side.
pub type Point = [f64; 2];

pub(crate) fn sub(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

pub(crate) fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// Outline of an object in its own frame: y away from the finger, x towards the fingertip.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// Cylinder across the plane of motion.
    Cylinder {
        /// Diameter, metre; zero is a point.
        diameter_m: f64,
    },
    /// Convex polygon.
    Polygon {
        /// Corners, counterclockwise, 3 to 12, metre.
        corners_m: Vec<Point>,
    },
}

impl Shape {
    /// A square bar, turned by `angle_deg` from lying flush on the phalanx (0) over its edge (45).
    #[must_use]
    pub fn square(side_m: f64, angle_deg: f64) -> Self {
        Self::rectangle(side_m, side_m, angle_deg)
    }

    /// A rectangular bar, `width_m` along the phalanx at `angle_deg` = 0.
    #[must_use]
    pub fn rectangle(width_m: f64, height_m: f64, angle_deg: f64) -> Self {
        let (w, h) = (0.5 * width_m, 0.5 * height_m);
        let (sin, cos) = angle_deg.to_radians().sin_cos();
        let turn = |[x, y]: Point| [cos * x - sin * y, sin * x + cos * y];
        Self::Polygon {
            corners_m: [[-w, -h], [w, -h], [w, h], [-w, h]].map(turn).to_vec(),
        }
    }

    /// A flat wall, wider than any phalanx, flush with it.
    #[must_use]
    pub fn plane() -> Self {
        Self::rectangle(0.4, 0.05, 0.0)
    }

    /// Checks sizes and convexity.
    fn validate(&self) -> Result<(), Error> {
        match self {
            Self::Cylinder { diameter_m } => {
                if (0.0..=1.0).contains(diameter_m) {
                    Ok(())
                } else {
                    Err(Error::Contact(format!(
                        "cylinder of {diameter_m} m, allowed 0 to 1"
                    )))
                }
            }
            Self::Polygon { corners_m } => {
                let count = corners_m.len();
                if !(3..=12).contains(&count) {
                    return Err(Error::Contact(format!(
                        "polygon of {count} corners, allowed 3 to 12"
                    )));
                }
                for i in 0..count {
                    let (a, b, c) = (
                        corners_m[i],
                        corners_m[(i + 1) % count],
                        corners_m[(i + 2) % count],
                    );
                    let (u, v) = (sub(b, a), sub(c, b));
                    let turn = u[0] * v[1] - u[1] * v[0];
                    // `is_nan` as well, because comparisons with NaN are false.
                    if turn.is_nan() || turn <= 0.0 {
                        return Err(Error::Contact(format!(
                            "polygon is not convex counterclockwise at corner {i}"
                        )));
                    }
                }
                Ok(())
            }
        }
    }

    /// The point of the outline nearest the finger (least y); the middle of a flush side.
    fn lowest(&self) -> Point {
        match self {
            Self::Cylinder { diameter_m } => [0.0, -0.5 * diameter_m],
            Self::Polygon { corners_m } => {
                let least = corners_m.iter().map(|c| c[1]).fold(f64::INFINITY, f64::min);
                let low = || corners_m.iter().filter(|c| c[1] < least + 1e-9);
                let left = low().map(|c| c[0]).fold(f64::INFINITY, f64::min);
                let right = low().map(|c| c[0]).fold(f64::NEG_INFINITY, f64::max);
                [0.5 * (left + right), least]
            }
        }
    }
}

/// Placement of the object.
#[derive(Clone, Debug, PartialEq, Default)]
pub enum Grasp {
    /// Nothing to grasp.
    #[default]
    Free,
    /// Placed so that the free finger touches it at a given place; see [`Grasp::touching`].
    Touching {
        /// Phalanx, from 1.
        phalanx: u8,
        /// Place from that phalanx's joint, metre.
        k_m: f64,
        /// theta_1 at first contact, radian.
        theta_1_rad: f64,
        /// Object.
        shape: Shape,
    },
    /// At a given position.
    At {
        /// Origin of the object's frame, metre.
        origin_m: Point,
        /// Rotation, counterclockwise, radian.
        angle_rad: f64,
        /// Object.
        shape: Shape,
    },
}

impl Grasp {
    /// An object that the free finger meets with phalanx `phalanx` (from 1) at `k_m` from its joint when joint 1 stands
    /// at `theta_1_rad`. Another phalanx may touch a large object earlier: see [`crate::Truth`].
    #[must_use]
    pub fn touching(phalanx: u8, k_m: f64, theta_1_rad: f64, shape: Shape) -> Self {
        Self::Touching {
            phalanx,
            k_m,
            theta_1_rad,
            shape,
        }
    }
}

/// An object in its place.
#[derive(Clone, Debug, PartialEq)]
pub enum Body {
    /// No object.
    Nothing,
    /// A cylinder across the plane of motion.
    Disc {
        /// Its axis, metre.
        centre: Point,
        /// Metre.
        radius: f64,
    },
    /// A convex polygon.
    Polygon {
        /// Counterclockwise, metre.
        corners: Vec<Point>,
    },
}

impl Body {
    /// Puts a shape's frame at `origin`, its x axis turned by `angle`.
    pub(crate) fn placed(shape: &Shape, origin: Point, angle: f64) -> Result<Self, Error> {
        shape.validate()?;
        if !(origin[0].is_finite() && origin[1].is_finite() && angle.is_finite()) {
            return Err(Error::Contact(format!(
                "object at {origin:?} m, {angle} rad"
            )));
        }
        let (sin, cos) = angle.sin_cos();
        let put = |[x, y]: Point| [origin[0] + cos * x - sin * y, origin[1] + sin * x + cos * y];
        Ok(match shape {
            Shape::Cylinder { diameter_m } => Self::Disc {
                centre: origin,
                radius: 0.5 * diameter_m,
            },
            Shape::Polygon { corners_m } => Self::Polygon {
                corners: corners_m.iter().copied().map(put).collect(),
            },
        })
    }

    /// Puts a shape so that its lowest point lies at `touch`, its x axis turned by `angle`.
    pub(crate) fn resting(shape: &Shape, touch: Point, angle: f64) -> Result<Self, Error> {
        shape.validate()?;
        let low = shape.lowest();
        let (sin, cos) = angle.sin_cos();
        let origin = [
            touch[0] - cos * low[0] + sin * low[1],
            touch[1] - sin * low[0] - cos * low[1],
        ];
        Self::placed(shape, origin, angle)
    }

    /// The same elsewhere.
    #[must_use]
    pub fn shifted(&self, by: Point) -> Self {
        let shift = |at: &Point| [at[0] + by[0], at[1] + by[1]];
        match self {
            Self::Nothing => Self::Nothing,
            Self::Disc { centre, radius } => Self::Disc {
                centre: shift(centre),
                radius: *radius,
            },
            Self::Polygon { corners } => Self::Polygon {
                corners: corners.iter().map(shift).collect(),
            },
        }
    }

    /// Reports every pair of nearby features of this body and a phalanx from `joint` along the unit vector `along` over
    /// `length`, with rounded ends of radius `half_thickness`.
    pub(crate) fn approach(
        &self,
        joint: Point,
        along: Point,
        length: f64,
        half_thickness: f64,
        mut report: impl FnMut(Near),
    ) {
        let mut point = |feature: u8, place: Point, radius: f64| {
            let offset = sub(place, joint);
            let k = dot(offset, along).clamp(0.0, length);
            let apart = [offset[0] - k * along[0], offset[1] - k * along[1]];
            let distance = dot(apart, apart).sqrt();
            if distance > 0.0 {
                let normal = [apart[0] / distance, apart[1] / distance];
                report(Near {
                    feature,
                    k,
                    normal,
                    gap: distance - radius - half_thickness,
                });
            }
        };
        match self {
            Self::Nothing => {}
            Self::Disc { centre, radius } => point(0, *centre, *radius),
            Self::Polygon { corners } => {
                for (feature, corner) in (0u8..).zip(corners) {
                    point(feature, *corner, 0.0);
                }
                let end = [joint[0] + length * along[0], joint[1] + length * along[1]];
                if let Some((distance, normal)) = face(corners, end) {
                    report(Near {
                        feature: FACE,
                        k: length,
                        normal,
                        gap: distance - half_thickness,
                    });
                }
            }
        }
    }
}

/// Feature number of the rounded end of a phalanx against a face.
const FACE: u8 = u8::MAX;

/// A pair of features of a phalanx and the object.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Near {
    /// Which feature of the object.
    pub feature: u8,
    /// Place on the phalanx's axis.
    pub k: f64,
    /// Unit vector from the phalanx to the object.
    pub normal: Point,
    /// Distance of the surfaces, negative when they overlap.
    pub gap: f64,
}

/// Signed distance from a point to the nearest face of a convex polygon, where the foot lies within that face, and the
/// unit vector from the point to the face.
fn face(corners: &[Point], from: Point) -> Option<(f64, Point)> {
    let mut best: Option<(f64, Point)> = None;
    let mut within = true;
    for (i, &corner) in corners.iter().enumerate() {
        let next = corners[(i + 1) % corners.len()];
        let edge = sub(next, corner);
        let length = dot(edge, edge).sqrt();
        let outward = [edge[1] / length, -edge[0] / length];
        let offset = sub(from, corner);
        let distance = dot(offset, outward);
        if best.is_none_or(|(most, _)| distance > most) {
            let foot = dot(offset, edge) / (length * length);
            within = (0.0..=1.0).contains(&foot);
            best = Some((distance, [-outward[0], -outward[1]]));
        }
    }
    best.filter(|_| within)
}
