// SPDX-License-Identifier: GPL-2.0-only
//! What the finger is to meet: how that is held, and whether it can be, in the units of the options that say it.

use palpate::app::console::command::NEAREST_PIN_MM;
use palpate_emulator::Error;
use palpate_emulator::sim::Object;
use palpate_plant::{Engine, Grasp, ObjectMount, Parameters};

/// Angles of joint 1 that are looked through for those an object allows, degree.
const ANGLES_DEG: std::ops::RangeInclusive<i32> = -180..=180;

/// Holds an object as the options say; a stiffness of springs implies that it is held by them.
///
/// # Errors
/// It is to be held otherwise.
pub fn hold(
    held: &mut palpate_plant::Object,
    mount: Option<ObjectMount>,
    n_per_mm: Option<f64>,
) -> Result<(), Error> {
    if let Some(n_per_mm) = n_per_mm {
        if let Some(mount @ (ObjectMount::Fixed | ObjectMount::Free)) = mount {
            let name = format!("{mount:?}").to_lowercase();
            return Err(Error::Call(format!(
                "--mount {name}: --object-n-per-mm {n_per_mm} implies --mount spring; leave one of the two out"
            )));
        }
        held.stiffness_n_per_m = 1e3 * n_per_mm;
        held.mount = ObjectMount::Spring;
    } else if let Some(mount) = mount {
        held.mount = mount;
    }
    Ok(())
}

/// Refuses a pin that calibrates anywhere but on the last phalanx.
///
/// # Errors
/// Option, value, and what is allowed.
pub fn check_pins(places_mm: &[f64], parameters: &Parameters) -> Result<(), Error> {
    let lengths = &parameters.finger.length_m;
    let (phalanx, length_m) = (lengths.len(), lengths.last().copied().unwrap_or_default());
    // The firmware takes whole millimetres, and what rounding has left of the last one counts.
    let length_mm = (1e3 * length_m + 1e-3).floor();
    let off = |place: &&f64| !(f64::from(NEAREST_PIN_MM)..=length_mm).contains(*place);
    let allowed = format!("{NEAREST_PIN_MM} to {length_mm} mm on phalanx {phalanx}");
    match places_mm.iter().find(off) {
        Some(place) => refused("--calibrate", place, &allowed),
        None => Ok(()),
    }
}

/// Refuses an object that cannot stand where it is wanted.
///
/// # Errors
/// Option, value, and what is allowed.
pub fn check(object: &Object, parameters: &Parameters) -> Result<(), Error> {
    let lengths = &parameters.finger.length_m;
    let Object {
        phalanx,
        contact_mm,
        diameter_mm,
        theta_1_deg,
    } = *object;
    let Some(length_m) = lengths.get(usize::from(phalanx).wrapping_sub(1)) else {
        return refused("--phalanx", phalanx, &format!("1 to {}", lengths.len()));
    };
    // Downwards: what is told as allowed must be.
    let length_mm = (1e4 * length_m).floor() / 10.0;
    if !(0.0..=length_mm).contains(&contact_mm) {
        let allowed = format!("0 to {length_mm} mm on phalanx {phalanx}");
        return refused("--contact-mm", contact_mm, &allowed);
    }
    // Objects are placed by the plant's own geometry, whatever engine moves them and however they are held then.
    let mut parameters = parameters.clone();
    parameters.engine = Engine::Plant;
    parameters.object.mount = ObjectMount::Fixed;
    let mut plant = palpate_mujoco::plant(&parameters, &Grasp::Free, 1)?;
    let Err(why) = plant.place(&object.grasp()) else {
        return Ok(());
    };
    let mut fits = |deg: &i32| {
        let theta_1_deg = f64::from(*deg);
        let turned = Object {
            theta_1_deg,
            ..*object
        };
        plant.place(&turned.grasp()).is_ok()
    };
    let allowed: Vec<i32> = ANGLES_DEG.filter(|deg| fits(deg)).collect();
    let there =
        format!("for a cylinder of {diameter_mm} mm at {contact_mm} mm of phalanx {phalanx}");
    match (allowed.first(), allowed.last()) {
        (Some(first), Some(last)) => {
            let allowed = format!("{first} to {last} degrees {there}");
            refused("--theta1-deg", theta_1_deg, &allowed)
        }
        // A hidden phalanx, for one.
        _ => Err(Error::Call(format!("no place {there}: {why}"))),
    }
}

fn refused(option: &str, value: impl std::fmt::Display, allowed: &str) -> Result<(), Error> {
    Err(Error::Call(format!("{option} {value}: {allowed}")))
}
