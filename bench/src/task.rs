//! The tasks: a name, the candidates, the inputs that the chip times.

use crate::candidate::Candidate;
use crate::function::{self, Angle, Equations};
use crate::rows;
use crate::step;
use crate::three::{self, ThreePhalanges};
use crate::two::{self, TwoPhalanges};

/// A task.
pub struct Task<'a, I: 'static, O: 'static> {
    /// Name in the report.
    pub name: &'static str,
    /// All candidates: same input, same promise.
    pub candidates: &'static [Candidate<I, O>],
    /// What they are timed on.
    pub timed: &'a [I],
    /// A function that does nothing with the same signature: the cost of being called.
    pub nothing: fn(&I) -> O,
}

/// Who goes through all tasks: the chip to time them, a PC to judge them.
pub trait Visitor {
    /// One task.
    fn task<I, O: Bits>(&mut self, task: &Task<'_, I, O>);
}

/// Results that a checksum can be taken of.
pub trait Bits {
    /// Mixes the result into a checksum. All NaN count as the same: their payloads are nobody's promise.
    fn mix(&self, checksum: u32) -> u32;
}

impl Bits for f32 {
    fn mix(&self, checksum: u32) -> u32 {
        let bits = if self.is_nan() {
            0x7FC0_0000
        } else {
            self.to_bits()
        };
        (checksum ^ bits).wrapping_mul(0x0100_0193).rotate_left(5)
    }
}

impl<const N: usize> Bits for [f32; N] {
    fn mix(&self, checksum: u32) -> u32 {
        self.iter()
            .fold(checksum, |checksum, value| value.mix(checksum))
    }
}

/// Checksum of a candidate's results over all timed inputs.
pub fn checksum<I, O: Bits>(task: &Task<'_, I, O>, candidate: &Candidate<I, O>) -> u32 {
    task.timed
        .iter()
        .fold(0, |sum, input| (candidate.run)(input).mix(sum))
}

macro_rules! nothing {
    ($name:ident, $input:ty, $output:ty, $value:expr) => {
        #[inline(never)]
        fn $name(_: &$input) -> $output {
            $value
        }
    };
}

nothing!(nothing_two, TwoPhalanges, [f32; 2], [0.0; 2]);
nothing!(nothing_three, ThreePhalanges, [f32; 2], [0.0; 2]);
nothing!(nothing_step, step::Ready<2, 1>, [f32; 2], [0.0; 2]);
nothing!(nothing_three_step, step::Ready<3, 2>, [f32; 2], [0.0; 2]);
nothing!(nothing_number, f32, f32, 0.0);
nothing!(nothing_angle, Angle, f32, 0.0);
nothing!(nothing_angles, Angle, [f32; 2], [0.0; 2]);
nothing!(nothing_equations, Equations, [f32; 3], [0.0; 3]);
nothing!(nothing_point, [f32; 2], f32, 0.0);

/// Shows a visitor every task.
pub fn visit(visitor: &mut impl Visitor) {
    visitor.task(&Task {
        name: "k2_2p",
        candidates: two::CANDIDATES,
        timed: rows::TWO_TIMED,
        nothing: nothing_two,
    });
    visitor.task(&Task {
        name: "k2_3p",
        candidates: three::CANDIDATES,
        timed: rows::THREE_TIMED,
        nothing: nothing_three,
    });
    two_steps(visitor);
    three_steps(visitor);
    visitor.task(&Task {
        name: "sqrt",
        candidates: function::SQRT,
        timed: rows::NUMBERS_TIMED,
        nothing: nothing_number,
    });
    visitor.task(&Task {
        name: "sin",
        candidates: function::SIN,
        timed: rows::ANGLES_TIMED,
        nothing: nothing_angle,
    });
    visitor.task(&Task {
        name: "sin_cos",
        candidates: function::SIN_COS,
        timed: rows::ANGLES_TIMED,
        nothing: nothing_angles,
    });
    visitor.task(&Task {
        name: "sin_cos_step",
        candidates: function::SIN_COS_STEP,
        timed: rows::ANGLES_TIMED,
        nothing: nothing_angles,
    });
    visitor.task(&Task {
        name: "atan2",
        candidates: function::ATAN2,
        timed: rows::POINTS_TIMED,
        nothing: nothing_point,
    });
    visitor.task(&Task {
        name: "recip",
        candidates: function::RECIP,
        timed: rows::NUMBERS_TIMED,
        nothing: nothing_number,
    });
    visitor.task(&Task {
        name: "ln",
        candidates: function::LN,
        timed: rows::NUMBERS_TIMED,
        nothing: nothing_number,
    });
    visitor.task(&Task {
        name: "solve_3",
        candidates: function::SOLVE,
        timed: rows::EQUATIONS_TIMED,
        nothing: nothing_equations,
    });
}

// Fingers are built here: a firmware has its finger ready. Each task gives its memory back before the next.

#[inline(never)]
fn two_steps(visitor: &mut impl Visitor) {
    let steps: heapless::Vec<step::Ready<2, 1>, { rows::TWO_STEPS_TIMED.len() }> =
        rows::TWO_STEPS_TIMED
            .iter()
            .filter_map(step::ready)
            .collect();
    visitor.task(&Task {
        name: "k2_2p_step",
        candidates: step::TWO,
        timed: &steps,
        nothing: nothing_step,
    });
}

#[inline(never)]
fn three_steps(visitor: &mut impl Visitor) {
    let steps: heapless::Vec<step::Ready<3, 2>, { rows::THREE_STEPS_TIMED.len() }> =
        rows::THREE_STEPS_TIMED
            .iter()
            .filter_map(step::ready)
            .collect();
    visitor.task(&Task {
        name: "k2_3p_step",
        candidates: step::THREE,
        timed: &steps,
        nothing: nothing_three_step,
    });
}
