//! `replay --calibrate FILE[@MM]`: a recording that calibrates.

use std::path::PathBuf;
use std::str::FromStr;

use palpate::app::console::command::NEAREST_PIN_MM;
use palpate::finger::Mechanics;
use palpate::scene::Scene;

/// A recording that calibrates.
#[derive(Clone, Debug, PartialEq)]
pub struct Teaching {
    pub file: PathBuf,
    /// Place of the pin, millimetre; `None` for a press.
    pin_mm: Option<f64>,
}

impl Teaching {
    /// Place of the pin, metre; `None` for a press.
    pub fn pin_m(&self) -> Option<f32> {
        self.pin_mm.map(|mm| (1e-3 * mm) as f32)
    }
}

impl FromStr for Teaching {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let Some((file, place)) = text.rsplit_once('@') else {
            return Ok(Self {
                file: text.into(),
                pin_mm: None,
            });
        };
        match place.parse::<f64>() {
            Ok(mm) if mm.is_finite() => Ok(Self {
                file: file.into(),
                pin_mm: Some(mm),
            }),
            _ => Err(format!("'{place}' is no place of a pin in millimetres")),
        }
    }
}

/// As it is written on the command line.
impl std::fmt::Display for Teaching {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(out, "{}", self.file.display())?;
        self.pin_mm.map_or(Ok(()), |mm| write!(out, "@{mm}"))
    }
}

/// Number and length of a scene's last phalanx; the length in millimetre, to a tenth.
fn last_phalanx<S: Scene>() -> (u8, f64) {
    let length_m = S::MECHANISM.phalanx_length_m(S::PHALANGES);
    let tenths = (1e4 * f64::from(length_m.unwrap_or_default())).round();
    (S::PHALANGES, tenths / 10.0)
}

/// Refuses a pin that does not stand at the last phalanx of the scene.
///
/// # Errors
/// Option, value, and what is allowed.
pub fn check(all: &[Teaching], scene: &str) -> Result<(), String> {
    let last = palpate_scenes::for_scene!(scene, |S| last_phalanx::<S>());
    let (phalanx, length_mm) = last.ok_or("no such scene")?;
    let allowed = f64::from(NEAREST_PIN_MM)..=length_mm;
    let off = |pin: &&Teaching| pin.pin_mm.is_some_and(|mm| !allowed.contains(&mm));
    match all.iter().find(off) {
        Some(pin) => Err(format!(
            "--calibrate {pin}: a pin of {scene} stands at {NEAREST_PIN_MM} to {length_mm} mm of phalanx {phalanx}"
        )),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Teaching {
        text.parse().expect("a recording")
    }

    #[test]
    fn a_pin_has_a_place_and_a_press_none() {
        let pin = read("a@b/pin.csv@21");
        assert_eq!(pin.file, PathBuf::from("a@b/pin.csv"));
        assert!(pin.pin_m().is_some_and(|k_m| (k_m - 0.021).abs() < 1e-6));
        assert_eq!(pin.to_string(), "a@b/pin.csv@21");
        assert_eq!(read("press.csv").pin_m(), None);
        for wrong in ["pin.csv@far", "pin.csv@nan", "pin.csv@"] {
            assert!(wrong.parse::<Teaching>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_pin_stands_at_the_last_phalanx_of_its_scene() {
        for (text, scene) in [
            ("press.csv", "p70"),
            ("pin.csv@1", "p70"),
            ("pin.csv@70", "p70"),
            ("pin.csv@45", "tendon3"),
        ] {
            assert_eq!(check(&[read(text)], scene), Ok(()), "{text}");
        }
        for (text, scene, allowed) in [
            ("pin.csv@500", "p70", "1 to 70 mm of phalanx 2"),
            ("pin.csv@-3", "p70", "1 to 70 mm of phalanx 2"),
            ("pin.csv@60", "tendon3", "1 to 45 mm of phalanx 3"),
        ] {
            let refused = check(&[read("press.csv"), read(text)], scene).expect_err(text);
            assert!(
                refused.contains(text) && refused.contains(allowed),
                "{refused}"
            );
        }
    }
}
