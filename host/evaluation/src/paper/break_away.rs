//! A finger of two phalanges whose joint 2 stands at its stop, held by a return cable or a preloaded spring: the torque with which
//! motion resumes after the contact.

use super::secant::{LEVEL_TURNS, Rule, level};
use super::turns::MotorTurn;
use super::{Model, PaperResult, place};

/// What holds joint 2 at its stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stopped {
    /// Transmission factor x_2 there.
    pub x_2: f64,
    /// Torque that holds it, newton metre: of a preloaded spring.
    pub preload_nm: f64,
    /// What a return cable adds, as a share of the torque of the free finger: its lever about joint 2 over that about joint 1, less x_2.
    pub share: f64,
}

/// The place from the turns of a closing, of which `touch` is the first above the threshold. Motion has resumed where the input link
/// has turned by more than the cable gives for some torque: the step of the rule, or the smallest one.
pub(super) fn locate(
    model: &Model,
    stopped: Stopped,
    turns: &[MotorTurn],
    touch: usize,
    rule: Rule,
) -> PaperResult {
    let (before, pressed) = turns.split_at(touch);
    let time_us = pressed[0].time_us;
    let touched = PaperResult::Touched { time_us };
    let quiet = &before[before.len().saturating_sub(LEVEL_TURNS)..];
    let Some((_, at_rad)) = level(quiet) else {
        return touched;
    };
    let friction_nm = quiet.iter().map(|turn| turn.excess_nm).sum::<f64>() / quiet.len() as f64;
    let free_nm = model.free_torque(at_rad);
    let step_nm = match rule {
        Rule::Rise(step_nm) => step_nm,
        Rule::TwoLevels => super::STEPS_NM[0],
    };
    let rise_nm = |turn: &MotorTurn| turn.torque_nm - friction_nm - free_nm;
    let resumed = pressed.iter().find(|turn| {
        let beyond_rad = turn.angle_rad - at_rad - model.cable_rad_per_nm * rise_nm(turn);
        beyond_rad > model.cable_rad_per_nm * step_nm
    });
    let Some(resumed) = resumed else {
        return touched;
    };
    let (rise_nm, finger) = (rise_nm(resumed), &model.finger);
    let (l_1, l_2) = (finger.lengths[0], finger.lengths[1]);
    // (T_b - T_0)(x_2 p_1 - p_2) = p_1 times what holds joint 2, solved for k.
    let opposed_nm = stopped.preload_nm + stopped.share * free_nm;
    let k =
        l_1 * (rise_nm * stopped.x_2 - opposed_nm) / (opposed_nm + rise_nm * (1.0 - stopped.x_2));
    if k < place::JOINT_SHARE * l_2 {
        return PaperResult::Proximal { time_us };
    }
    PaperResult::Located {
        time_us,
        phalanx: 2,
        k: k.min(l_2),
    }
}
