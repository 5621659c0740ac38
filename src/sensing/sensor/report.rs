//! What a round of the locator says, and whether it is news.

use super::known::Known;
use super::touch::{Reported, Touching};
use crate::finger::Mechanics;
use crate::numeric::Bounded;
use crate::sensing::fit::Estimate;
use crate::sensing::joint::JointSensor;
use crate::sensing::location::Series;
use crate::sensing::locator::{self, Verdict};
use crate::sensing::{Event, NotLocated};

/// A deviation that shrinks by less than this factor while the torque grows by a quarter will not be worth more torque.
const NO_HELP: f32 = 0.93;
/// Deviation of k, as a share of the phalanx, above which all the torque there is will be used: far up the curve its bend
/// tells what the slope alone cannot.
const SHARP: f32 = 0.012;
/// Deviation of k, as a share of the phalanx, above which no location is reported.
const VAGUE: f32 = 0.25;
/// Mean square residual, in variances, up to which a curve counts as explained well.
const GOOD: f32 = 4.0;
/// Growth of it with which a curve has left its path.
const WORSE: f32 = 5.0;
/// Rounds that it takes to believe it.
const WORSE_ROUNDS: u8 = 4;
/// A location is reported anew when its deviation has shrunk by this factor.
const SHARPER: f32 = 0.75;

impl<F: Mechanics, H: JointSensor, X: Series> Known<F, H, X> {
    fn verdict(&mut self, touching: &Touching<H::Reading>, misfit: f32) -> Verdict {
        let touch = &touching.touch;
        // To the end of the curve, which is what was fitted: the finger may have moved on.
        self.joint_change = H::change(touch.reading, touch.waiting.reading);
        let change_rad = H::rad(self.joint_change);
        touching.locator.verdict(misfit, |estimate| {
            change_rad.map_or(0.0, |measured| {
                let [_, expected, _] = estimate.joints_rad;
                locator::ln_likelihood(measured, expected, H::SIGMA_RAD)
            })
        })
    }

    /// Says what is new at the end of a round; `last` is the last word.
    pub(super) fn report(&mut self, touching: &mut Touching<H::Reading>, last: bool) {
        if touching.settled {
            return;
        }
        let misfit = touching.locator.misfit();
        let mut verdict = self.verdict(touching, misfit);
        let mut over = last || touching.touch.torque_nm >= 0.97 * self.settings.torque_limit_nm;
        let was = touching.good.map_or(misfit, |(_, was)| was);
        if misfit > (WORSE * was.at_least(1.0)).at_least(GOOD) {
            touching.worse = touching.worse.saturating_add(1);
        } else {
            touching.worse = 0;
        }
        let left = touching.worse >= WORSE_ROUNDS;
        let undecided = matches!(verdict, Verdict::Undecided);
        match &touching.good {
            // The curve has left the path that explained it well: a second contact, a slip. What was known before holds. A
            // round or two may just be a fit on its way.
            Some((good, _)) if left || undecided => {
                verdict = *good;
                over |= left;
            }
            _ if misfit <= GOOD && !undecided => touching.good = Some((verdict, misfit)),
            _ => {}
        }
        if touching.worse == 0 || over {
            self.say(touching, &verdict, over, last);
        }
    }

    /// Says a verdict, if it is news; `over`: no more torque will come of use.
    fn say(
        &mut self,
        touching: &mut Touching<H::Reading>,
        verdict: &Verdict,
        over: bool,
        last: bool,
    ) {
        match verdict {
            Verdict::At(estimate) => {
                let sigma_m = estimate.k_sigma_m;
                let length = estimate.length_m;
                let help = self.more_torque_helps(touching, sigma_m) || sigma_m > SHARP * length;
                let settled = over || sigma_m <= self.settings.wanted_sigma_m || !help;
                if sigma_m >= VAGUE * length {
                    if over {
                        self.tell_nowhere(touching, NotLocated::TooFewSamples);
                    }
                    return;
                }
                let news = match touching.reported {
                    Reported::Located {
                        phalanx: before,
                        k_m,
                        sigma_m: was,
                    } => {
                        before != estimate.phalanx
                            || sigma_m < SHARPER * was
                            || (estimate.k_m - k_m).abs() > 2.0 * was
                    }
                    _ => true,
                };
                touching.settled = settled;
                if news || settled {
                    self.tell_located(touching, estimate);
                }
            }
            Verdict::Either(estimates) => {
                touching.settled = over;
                if !matches!(touching.reported, Reported::Ambiguous) || over {
                    self.tell_ambiguous(touching, estimates);
                }
            }
            Verdict::Nowhere(why) => {
                // A proximal contact is not told from one near the joint before the torque has shown the difference.
                let sure = touching.touch.torque_nm >= 0.3 * self.settings.torque_limit_nm;
                if over || (sure && *why == NotLocated::Proximal) {
                    self.tell_nowhere(touching, *why);
                }
            }
            Verdict::Undecided if last => self.tell_nowhere(touching, NotLocated::TooFewSamples),
            Verdict::Undecided => {}
        }
    }

    fn tell_nowhere(&mut self, touching: &mut Touching<H::Reading>, why: NotLocated) {
        touching.settled = true;
        self.tell(Event::NotLocated {
            why,
            torque_nm: touching.touch.torque_nm,
        });
    }

    /// Whether the deviation still shrinks as the torque grows.
    fn more_torque_helps(&self, touching: &mut Touching<H::Reading>, sigma_m: f32) -> bool {
        let (torque_nm, was_m) = touching.asked;
        if touching.touch.torque_nm < 1.25 * torque_nm {
            return true;
        }
        touching.asked = (touching.touch.torque_nm, sigma_m);
        // Early deviations say little: the fit may not stand still yet.
        touching.touch.torque_nm < 0.4 * self.settings.torque_limit_nm || sigma_m < NO_HELP * was_m
    }

    fn tell_located(&mut self, touching: &mut Touching<H::Reading>, estimate: &Estimate) {
        let &Estimate {
            phalanx,
            k_m,
            k_sigma_m: sigma_m,
            ..
        } = estimate;
        let k_c = self
            .free(estimate.onset_rad)
            .and_then(|free| {
                self.finger
                    .contact_compliance(&free.configuration, free.torque_nm, phalanx, k_m)
            })
            .map_or(f32::INFINITY, |compliance| 1.0 / compliance);
        touching.reported = Reported::Located {
            phalanx,
            k_m,
            sigma_m,
        };
        // No better than the prior: the curve does not tell.
        let (radius_m, radius_sigma_m) =
            if estimate.radius_sigma_m < 0.7 * self.settings.radius_sigma_m {
                (estimate.radius_m, estimate.radius_sigma_m)
            } else {
                (f32::NAN, f32::NAN)
            };
        self.tell(Event::Located {
            phalanx,
            k_m,
            sigma_m,
            k_c_nm_per_rad: k_c,
            force_n: estimate.force_n,
            radius_m,
            radius_sigma_m,
            settled: touching.settled,
        });
    }

    fn tell_ambiguous(&mut self, touching: &mut Touching<H::Reading>, estimates: &[Estimate; 2]) {
        touching.reported = Reported::Ambiguous;
        let [likelier, other] = estimates;
        self.tell(Event::Ambiguous {
            phalanx: [likelier.phalanx, other.phalanx],
            k_m: [likelier.k_m, other.k_m],
            sigma_m: [likelier.k_sigma_m, other.k_sigma_m],
            settled: touching.settled,
        });
    }
}
