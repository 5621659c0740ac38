//! What is drawn of a grasp, for screen and page alike: the finger as strokes in its plane, and curves over common axes. Each
//! of the two only chooses colours and turns metres into cells or pixels.

use crate::posture::{FingerView, Points, Touch};
use crate::state::{Place, State};

/// Half the thickness of a phalanx, metre, as drawn.
const HALF_THICKNESS_M: f64 = 0.006;
/// Length of the arrow of one newton, metre.
const ARROW_M_PER_N: f64 = 0.015;
/// Longest arrow, metre.
const ARROW_MOST_M: f64 = 0.06;
/// Largest rise of torque that the estimate's curve is followed to, newton metre.
const CURVE_NM: f64 = 0.5;
/// Steps of a belief's curve.
const BELIEF_STEPS: u8 = 120;

/// What a stroke or a curve stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// The finger itself, or what was measured.
    Measured,
    /// The likeliest place, and what it predicts.
    Estimate,
    /// The other place of an ambiguous contact.
    Alternative,
    /// What a simulation knows.
    Truth,
    /// Friction as recorded.
    Friction,
    /// Where the detector would call a contact.
    Threshold,
}

/// A straight line, metre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke {
    /// One end.
    pub from: [f64; 2],
    /// The other.
    pub to: [f64; 2],
    /// What it stands for.
    pub role: Role,
}

/// The finger as it is drawn.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    /// Outlines, bands and arrows.
    pub strokes: Vec<Stroke>,
    /// Joints and tip: centre and radius, metre.
    pub circles: Vec<([f64; 2], f64)>,
    /// Where the contact really is.
    pub truth: Option<[f64; 2]>,
}

/// A curve, or single points.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// For the legend.
    pub name: &'static str,
    /// What it stands for.
    pub role: Role,
    /// A line through the points.
    pub joined: bool,
    /// In the units of the axes.
    pub points: Vec<(f64, f64)>,
}

/// Where the contact is believed to be.
#[derive(Clone, Debug, PartialEq)]
pub struct LocationDensity {
    /// Density, and the truth as an upright line.
    pub series: Vec<Series>,
    /// Ends of the axis, millimetre.
    pub range_mm: (f64, f64),
    /// What the axis shows.
    pub axis: String,
}

/// Least and largest of the finite values, kept apart; `otherwise` where there are none.
#[must_use]
pub fn range(values: impl Iterator<Item = f64>, otherwise: (f64, f64)) -> (f64, f64) {
    let (low, high) = values
        .filter(|value| value.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        });
    if low < high {
        (low, high)
    } else if low.is_finite() {
        (low - 1.0, low + 1.0)
    } else {
        otherwise
    }
}

/// The contact as the mechanics wants it, from the last word on it.
pub fn touch_of(state: &State, finger: &dyn FingerView) -> Option<Touch> {
    let contact = state.contact.as_ref()?;
    let place = contact.places.first()?;
    let nominal = finger.scales().cable_rad_per_nm;
    Some(Touch {
        theta_a_rad: contact.touch_rad?,
        phalanx: place.phalanx,
        k_m: 1e-3 * place.k_mm,
        radius_m: 1e-3 * contact.radius_mm.unwrap_or(0.0),
        cable_rad_per_nm: state.cable_rad_per_nm.unwrap_or(nominal),
    })
}

/// The finger at an input angle, along the contact's path as far as there is one.
pub fn points_at(state: &State, finger: &mut dyn FingerView, theta_a_rad: f64) -> Option<Points> {
    let touch = touch_of(state, finger);
    finger
        .points(theta_a_rad, touch)
        .or_else(|| finger.points(theta_a_rad, None))
}

/// The finger with the contact, its band of two deviations, the force, and the truth where it is known.
#[must_use]
pub fn posture(points: &Points, state: &State) -> Picture {
    let mut picture = Picture::default();
    for pair in points.windows(2) {
        let ([x1, y1], [x2, y2]) = (pair[0], pair[1]);
        let length = (x2 - x1).hypot(y2 - y1).max(f64::MIN_POSITIVE);
        let (nx, ny) = (
            -(y2 - y1) / length * HALF_THICKNESS_M,
            (x2 - x1) / length * HALF_THICKNESS_M,
        );
        for side in [-1.0, 1.0] {
            picture.strokes.push(Stroke {
                from: [x1 + side * nx, y1 + side * ny],
                to: [x2 + side * nx, y2 + side * ny],
                role: Role::Measured,
            });
        }
    }
    picture.circles = points
        .iter()
        .map(|point| (*point, HALF_THICKNESS_M))
        .collect();
    if let Some(contact) = &state.contact {
        for (rank, place) in contact.places.iter().enumerate() {
            let role = if rank == 0 {
                Role::Estimate
            } else {
                Role::Alternative
            };
            picture.mark(points, place, contact.force_n, role);
        }
    }
    picture.truth = state.truth.and_then(|(phalanx, k_mm, _)| {
        let (at, normal) = along(points, phalanx, 1e-3 * k_mm)?;
        Some(lifted(at, normal, HALF_THICKNESS_M))
    });
    picture
}

impl Picture {
    /// Band and arrow of a place, on the palm side.
    fn mark(&mut self, points: &Points, place: &Place, force_n: Option<f64>, role: Role) {
        let at = |k_mm: f64| along(points, place.phalanx, 1e-3 * k_mm.max(0.0));
        let (Some((low, normal)), Some((high, _)), Some((middle, _))) = (
            at(place.k_mm - 2.0 * place.sigma_mm),
            at(place.k_mm + 2.0 * place.sigma_mm),
            at(place.k_mm),
        ) else {
            return;
        };
        let surface = |point, lift_m: f64| lifted(point, normal, HALF_THICKNESS_M + lift_m);
        let mut stroke = |from, to| self.strokes.push(Stroke { from, to, role });
        stroke(surface(low, 0.002), surface(high, 0.002));
        stroke(surface(low, 0.0), surface(low, 0.004));
        stroke(surface(high, 0.0), surface(high, 0.004));
        let Some(force_n) = force_n.filter(|force| *force > 0.0) else {
            return;
        };
        // The object presses on the phalanx, against its normal.
        let head = surface(middle, 0.0);
        let length_m = 0.004 + (ARROW_M_PER_N * force_n).min(ARROW_MOST_M);
        stroke(surface(middle, length_m), head);
        let side = [normal[1], -normal[0]];
        for wing in [-1.0, 1.0] {
            let from = lifted(lifted(head, normal, 0.006), side, wing * 0.003);
            stroke(from, head);
        }
    }
}

fn lifted(point: [f64; 2], along: [f64; 2], by_m: f64) -> [f64; 2] {
    [point[0] + by_m * along[0], point[1] + by_m * along[1]]
}

/// A place on a phalanx and the unit vector to its palm side.
fn along(points: &Points, phalanx: u32, k_m: f64) -> Option<([f64; 2], [f64; 2])> {
    let first = usize::try_from(phalanx).ok()?.checked_sub(1)?;
    let ([x1, y1], [x2, y2]) = (*points.get(first)?, *points.get(first + 1)?);
    let length = (x2 - x1).hypot(y2 - y1);
    let share = (k_m / length).clamp(0.0, 1.0);
    let normal = [-(y2 - y1) / length, (x2 - x1) / length];
    Some(([x1 + share * (x2 - x1), y1 + share * (y2 - y1)], normal))
}

/// Title of the axes of [`torque`]: the motor's torque as the nominal gears would bring it to the input link.
pub const TORQUE_AXES: &str = "motor torque, mN m, against angle, deg";

/// Motor torque at the input link (nominal) while closing, in millinewton metre, against its angle in degrees, with the
/// recorded friction and what it leaves unexplained, and the curve that the estimate predicts.
pub fn torque(state: &State, finger: &dyn FingerView) -> Vec<Series> {
    let scales = finger.scales();
    let measured: Vec<(f64, f64)> = state
        .samples
        .iter()
        .filter(|sample| sample.duty > 0.0)
        .map(|sample| {
            (
                (sample.counts * scales.rad_per_count).to_degrees(),
                1e3 * scales.nm_per_a * sample.current_a,
            )
        })
        .collect();
    let (low, high) = range(measured.iter().map(|point| point.0), (0.0, 90.0));
    let friction_nm = state.friction_nm;
    let level = |torque_nm: f64| vec![(low, 1e3 * torque_nm), (high, 1e3 * torque_nm)];
    let band = |side: f64| {
        let residual_nm = state.friction_residual_nm?;
        Some(level(friction_nm? + side * 2.0 * residual_nm))
    };
    let predicted: Vec<(f64, f64)> = touch_of(state, finger)
        .map(|touch| finger.curve(touch, CURVE_NM))
        .unwrap_or_default()
        .into_iter()
        .map(|(theta_a_rad, torque_nm)| {
            // What the motor has to give beyond friction; the calibration scales the gears' nominal efficiency.
            let factor = state.torque_factor.map_or(1.0, |factor| factor.0);
            let motor_nm = torque_nm / (scales.efficiency * factor);
            (
                theta_a_rad.to_degrees(),
                1e3 * (friction_nm.unwrap_or_default() + motor_nm),
            )
        })
        .collect();
    let line = |name, role, points| Series {
        name,
        role,
        joined: true,
        points,
    };
    let most = range(measured.iter().map(|point| point.1), (0.0, 100.0)).1;
    // The prediction goes on where the finger did not: drawn as far as what was measured.
    let predicted = predicted
        .into_iter()
        .filter(|point| measured.is_empty() || point.1 <= 1.2 * most)
        .collect();
    vec![
        Series {
            name: "motor",
            role: Role::Measured,
            joined: false,
            points: measured,
        },
        line(
            "friction, mean",
            Role::Friction,
            friction_nm.map(level).unwrap_or_default(),
        ),
        line(
            "± 2 deviations",
            Role::Friction,
            band(1.0).unwrap_or_default(),
        ),
        line("", Role::Friction, band(-1.0).unwrap_or_default()),
        line("estimate", Role::Estimate, predicted),
    ]
}

/// Title of the axes of [`evidence`].
pub const EVIDENCE_AXES: &str =
    "evidence of a contact (logarithm of its likelihood ratio) against the input link's angle, deg";

/// How the evidence of a contact grew until it exceeded its threshold; empty where the samples do not tell.
pub fn evidence(state: &State, finger: &dyn FingerView) -> Vec<Series> {
    let scale = finger.scales().rad_per_count;
    let told: Vec<(f64, (f64, f64))> = state
        .samples
        .iter()
        .filter_map(|sample| Some(((sample.counts * scale).to_degrees(), sample.evidence?)))
        .collect();
    let series = |name, role, value: fn((f64, f64)) -> f64| Series {
        name,
        role,
        joined: true,
        points: told.iter().map(|&(at, both)| (at, value(both))).collect(),
    };
    vec![
        series("evidence", Role::Measured, |both| both.0),
        series("threshold", Role::Threshold, |both| both.1),
    ]
}

/// Belief in the contact location, as the reported places and deviations give it: a normal density for each. On one phalanx
/// it is counted from that one's joint, otherwise from the first joint along the finger. `None` without a place.
pub fn belief(state: &State, finger: &dyn FingerView) -> Option<LocationDensity> {
    let places = &state.contact.as_ref()?.places;
    let first = places.first()?;
    let lengths_mm: Vec<f64> = finger.lengths_m().iter().map(|m| 1e3 * m).collect();
    let one = places.iter().all(|place| place.phalanx == first.phalanx)
        && state.truth.is_none_or(|truth| truth.0 == first.phalanx);
    let before = |phalanx: u32| -> f64 {
        lengths_mm
            .iter()
            .take(phalanx.saturating_sub(1) as usize)
            .sum()
    };
    let base = |phalanx: u32| if one { 0.0 } else { before(phalanx) };
    let end = before(first.phalanx + 1) - before(first.phalanx);
    let end = if one { end } else { lengths_mm.iter().sum() };
    let centres: Vec<(f64, f64, f64)> = places
        .iter()
        .map(|place| {
            let sigma = place.sigma_mm.max(0.05);
            (base(place.phalanx) + place.k_mm, sigma, place.weight)
        })
        .collect();
    let true_mm = state.truth.map(|(phalanx, k_mm, _)| base(phalanx) + k_mm);
    let (low, high) = range(
        centres
            .iter()
            .flat_map(|(at, sigma, _)| [at - 5.0 * sigma, at + 5.0 * sigma])
            .chain(true_mm.iter().flat_map(|at| [at - 1.0, at + 1.0])),
        (0.0, end),
    );
    let (low, high) = (low.max(0.0), high.min(end));
    let density = |at: f64| -> f64 {
        centres
            .iter()
            .map(|(centre, sigma, weight)| {
                let z = (at - centre) / sigma;
                weight * (-0.5 * z * z).exp() / (sigma * std::f64::consts::TAU.sqrt())
            })
            .sum()
    };
    let points: Vec<(f64, f64)> = (0..=BELIEF_STEPS)
        .map(|n| low + (high - low) * f64::from(n) / f64::from(BELIEF_STEPS))
        .map(|at| (at, density(at)))
        .collect();
    let most = points.iter().map(|point| point.1).fold(1e-6, f64::max);
    let mut series = vec![Series {
        name: "belief, 1/mm",
        role: Role::Estimate,
        joined: true,
        points,
    }];
    if let Some(at) = true_mm {
        series.push(Series {
            name: "truth",
            role: Role::Truth,
            joined: true,
            points: vec![(at, 0.0), (at, most)],
        });
    }
    let axis = if one {
        format!("k on phalanx {}, mm", first.phalanx)
    } else {
        "from the first joint, mm".to_owned()
    };
    Some(LocationDensity {
        series,
        range_mm: (low, high),
        axis,
    })
}

#[cfg(test)]
mod tests;
