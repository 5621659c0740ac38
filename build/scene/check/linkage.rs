//! What a linkage must satisfy: it closes wherever its joint may be, and closes its joint as the motor closes.

use std::f64::consts::{PI, TAU};

use super::super::Scene;
use super::{Checked, within};

/// How far the coupler must stay from stretched and folded, as a share of a + b: twice what the library asks in single precision.
const DEAD_POINT_MARGIN: f64 = 2e-5;
/// Largest angle between driven lever and phalanx that is taken for one in radians, degree; a lever in line with its phalanx has 0.
const RADIANS_DEG: f64 = PI;
/// Angles over the range of a joint at which its stage is tried.
const STEPS: u32 = 64;

/// A four-bar (docs/MECHANICS.md#transmission): ground, driving lever, coupler, driven lever and its offset, radian.
#[derive(Clone, Copy)]
pub(super) struct Stage {
    ground: f64,
    a: f64,
    b: f64,
    c: f64,
    offset: f64,
    mode: f64,
}

impl Stage {
    /// The stages of a linkage, the one that drives phalanx 2 first; none without a linkage.
    pub(super) fn all(scene: &Scene) -> Vec<Self> {
        let ground = scene.list("finger.length_m");
        let [a, b, c, offset] = ["driving_m", "coupler_m", "driven_m", "offset_deg"]
            .map(|name| scene.list(&format!("linkage.{name}")));
        let words = scene.words("linkage.assembly");
        (words.iter().enumerate())
            .map(|(i, word)| Self {
                ground: ground[i],
                a: a[i],
                b: b[i],
                c: c[i],
                offset: offset[i].to_radians(),
                mode: if *word == "clockwise" { -1.0 } else { 1.0 },
            })
            .collect()
    }

    /// End of the driven lever where its joint is at `v`, and its distance from the driving lever's pivot.
    fn tip(&self, v: f64) -> ([f64; 2], f64) {
        let (sin, cos) = (v - self.offset).sin_cos();
        let tip = [self.ground + self.c * cos, self.c * sin];
        (tip, tip[0].hypot(tip[1]))
    }

    /// Cosine of the angle between the driving lever and the line to that end: within -1 and 1 where the coupler reaches.
    fn cosine(&self, reach: f64) -> f64 {
        (self.a * self.a + reach * reach - self.b * self.b) / (2.0 * self.a * reach)
    }

    /// F, from v = 0, where the stage closes at both.
    pub(super) fn turned(&self, v: f64) -> f64 {
        let angle = |v: f64| {
            let (tip, reach) = self.tip(v);
            tip[1].atan2(tip[0]) + self.mode * self.cosine(reach).acos()
        };
        let turn = (angle(v) - angle(0.0)).rem_euclid(TAU);
        if turn > PI { turn - TAU } else { turn }
    }

    /// F', where the stage closes.
    pub(super) fn ratio(&self, v: f64) -> f64 {
        let (tip, reach) = self.tip(v);
        let square = reach * reach;
        let across = -self.ground * (v - self.offset).sin();
        let along = tip[0] - self.ground;
        let direction = (self.c * self.c + self.ground * along) / square;
        let cosine = self.cosine(reach);
        let slope = self.c * across / reach / (2.0 * self.a)
            * (1.0 - (self.a * self.a - self.b * self.b) / square);
        direction - self.mode * slope / (1.0 - cosine * cosine).sqrt()
    }

    /// Checks that the coupler reaches at `v`; `place` names that angle.
    fn reaches(&self, stage: usize, v: f64, place: &dyn Fn() -> String) -> Checked {
        let (_, reach) = self.tip(v);
        let key = format!("linkage.coupler_m[{stage}]");
        let (nearest, farthest) = ((reach - self.a).abs(), reach + self.a);
        if self.cosine(reach).abs() >= 1.0 {
            let open = format!("linkage {} does not close at {}", stage + 1, place());
            within(&key, self.b, nearest, farthest).map_err(|range| format!("{open}: {range}"))?;
        }
        let margin = DEAD_POINT_MARGIN * (self.a + self.b);
        let clear = (self.a - self.b).abs() + margin <= reach && reach + margin <= self.a + self.b;
        if clear {
            return Ok(());
        }
        Err(format!(
            "linkage {} is at a dead point at {}: `{key}` = {} must stay off {nearest:.6} and {farthest:.6} by {:.1e}, or the coupler is \
             in line with the driving lever",
            stage + 1,
            place(),
            self.b,
            margin
        ))
    }
}

/// Checks every stage of a linkage.
pub(super) fn check(scene: &Scene) -> Checked {
    for (i, offset) in scene.list("linkage.offset_deg").into_iter().enumerate() {
        if offset != 0.0 && offset.abs() <= RADIANS_DEG {
            return Err(format!(
                "`linkage.offset_deg[{i}]` = {offset} is out of range, allowed 0, or -180 to 180 degrees but for those between \
                 -3.1416 and 3.1416: they are taken for radians"
            ));
        }
    }
    let [low, high, rest] = ["joint_min_deg", "joint_max_deg", "rest_deg"]
        .map(|name| scene.list(&format!("finger.{name}")));
    let stages = Stage::all(scene);
    // What the stage behind adds to the angle of this one: least, most, and at rest.
    let mut behind = [0.0, 0.0, 0.0];
    for (i, stage) in stages.iter().enumerate().rev() {
        let (from, to) = (
            low[i + 1].to_radians() + behind[0],
            high[i + 1].to_radians() + behind[1],
        );
        let is_last = i + 1 == stages.len();
        let named = |v: f64| {
            let angle = format!("theta_{} = {:.0} deg", i + 2, v.to_degrees());
            if v < from || v > to {
                format!("{angle}, from where the input link's angle counts")
            } else if is_last {
                angle
            } else {
                format!("{angle} (with the stage behind)")
            }
        };
        let mut turned = [0.0f64, 0.0];
        for v in angles(stage, from, to) {
            stage.reaches(i, v, &|| named(v))?;
        }
        for v in angles(stage, from, to) {
            let turn = stage.turned(v);
            turned = [turned[0].min(turn), turned[1].max(turn)];
        }
        let rest = rest[i + 1].max(low[i + 1]).to_radians() + behind[2];
        closes_its_joint(scene, stage, i, rest)?;
        behind = [turned[0], turned[1], stage.turned(rest)];
    }
    Ok(())
}

/// Angles from one stop to the other and on to zero, from where F counts, with those where the coupler's end is farthest and nearest.
fn angles(stage: &Stage, from: f64, to: f64) -> impl Iterator<Item = f64> {
    let between = move |step: u32| from + (to - from) * f64::from(step) / f64::from(STEPS);
    let (least, most) = (from.min(0.0), to.max(0.0));
    let in_line = (-4..=4).map(move |half_turns| f64::from(half_turns) * PI + stage.offset);
    (0..=STEPS)
        .map(between)
        .chain([0.0])
        .chain(in_line.filter(move |v| (least..=most).contains(v)))
}

/// Checks that the motor closes a joint from its rest. Beyond an angle where F' is zero it would open the joint; it takes none there.
fn closes_its_joint(scene: &Scene, stage: &Stage, i: usize, rest: f64) -> Checked {
    let ratio = stage.ratio(rest);
    if ratio > 0.0 {
        return Ok(());
    }
    let words = scene.words("linkage.assembly");
    let mode = -stage.mode;
    let (key, word) = (format!("linkage.assembly[{i}]"), words[i]);
    let opens = format!(
        "linkage {} opens joint {} as the motor closes, at rest by F' = {ratio:.3}",
        i + 1,
        i + 2
    );
    let other = if mode < 0.0 {
        "clockwise"
    } else {
        "counterclockwise"
    };
    if (Stage { mode, ..*stage }).ratio(rest) > 0.0 {
        return Err(format!("{opens}: `{key}` = \"{word}\" must be \"{other}\""));
    }
    Err(format!(
        "{opens}, and as `{key}` = \"{other}\" too: `linkage.offset_deg[{i}]` = {} must be an angle at which the driving lever closes \
         the joint",
        stage.offset.to_degrees()
    ))
}
