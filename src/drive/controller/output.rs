//! What the bridge shall do in the next period: setpoint and faults to loops and outputs.

use super::{Controller, WAKE_PERIODS};
use crate::drive::convert::{self, PERIOD_S};
use crate::drive::demand::Setpoint;
use crate::drive::io::Outputs;
use crate::drive::limit::{inward, limit_magnitude};
use crate::drive::protect::{OFFSET_SLOT, SLOTS};
use crate::numeric::clamp;

/// The slot in which the speed loop steps: that of the lightest detector. The slot is counted before its period, the step after it.
const SPEED_SLOT: u8 = OFFSET_SLOT;
/// Change of a demanded current a period, as a share of the limit: the limit is reached in 5 ms.
const CURRENT_SLEW: f32 = 0.01;

impl Controller {
    /// Outputs for a setpoint.
    pub(super) fn decide(&mut self, setpoint: Setpoint) -> Outputs {
        let wanted = if self.status.fault.is_some() {
            Setpoint::Off
        } else {
            setpoint
        };
        let speed = self.encoder.speed();
        if matches!(wanted, Setpoint::Off) {
            self.rest();
            self.waking = WAKE_PERIODS;
            return Outputs::Off;
        }
        if self.waking > 0 {
            self.waking -= 1;
            self.rest();
            return Outputs::Wake;
        }
        let reference_a = match wanted {
            Setpoint::Off | Setpoint::Brake | Setpoint::MeasureOffset => {
                self.rest();
                return Outputs::Brake;
            }
            Setpoint::Current { a } => {
                self.in_speed = false;
                self.slewed(a, speed)
            }
            Setpoint::Speed {
                counts_per_s,
                current_limit_a,
            } => {
                if !self.in_speed {
                    self.in_speed = true;
                    self.speed.preset(speed, self.reference_a);
                }
                if self.average.periods() % SLOTS == SPEED_SLOT + 1 {
                    let (wanted, suppressed) = inward(counts_per_s * PERIOD_S, self.beyond_counts);
                    let limit_a = clamp(current_limit_a, 0.0, self.current_limit_a);
                    if suppressed {
                        self.average.limited.position = true;
                    }
                    self.speed
                        .step(wanted, speed, limit_a, &mut self.average.limited)
                } else {
                    self.reference_a
                }
            }
        };
        self.reference_a = reference_a;
        let fraction = self.current.step(
            reference_a,
            self.measured_a,
            speed,
            self.per_supply_v,
            &mut self.average.limited,
        );
        if fraction * self.applied_fraction < 0.0 {
            // The direction pin acts at once, the duty with the timer's next update: one period of brake between them.
            return Outputs::Brake;
        }
        convert::drive(fraction)
    }

    /// Resets both loops: no current is demanded.
    fn rest(&mut self) {
        self.reference_a = 0.0;
        self.in_speed = false;
        self.current.reset();
    }

    /// Current reference on its way to a demanded current, within the limits of current, speed, travel and slew.
    fn slewed(&mut self, demanded_a: f32, speed: f32) -> f32 {
        let (inward_a, suppressed) = inward(demanded_a, self.beyond_counts);
        let (allowed_a, current_limited) = limit_magnitude(inward_a, self.current_limit_a);
        let (down_a, up_a) = self.speed.current_bounds_a(speed);
        let bounded_a = clamp(allowed_a, down_a, up_a);
        let slew_a = CURRENT_SLEW * self.current_limit_a;
        let (change_a, _) = limit_magnitude(bounded_a - self.reference_a, slew_a);
        let limited = &mut self.average.limited;
        limited.position |= suppressed;
        limited.current |= current_limited;
        limited.speed |= bounded_a != allowed_a;
        self.reference_a + change_a
    }
}
