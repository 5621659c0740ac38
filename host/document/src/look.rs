//! Fonts and colours of every figure.

use plotters::style::{FontStyle, RGBColor};

/// The name under which figures ask for the font that they bring along.
pub const FONT: &str = "sans-serif";

/// Colours that stay apart in print and for colour-blind readers (Okabe and Ito).
pub const BLUE: RGBColor = RGBColor(0, 114, 178);
/// See [`BLUE`].
pub const ORANGE: RGBColor = RGBColor(213, 94, 0);
/// See [`BLUE`].
pub const GREEN: RGBColor = RGBColor(0, 158, 115);
/// See [`BLUE`].
pub const PINK: RGBColor = RGBColor(204, 121, 167);
/// See [`BLUE`].
pub const AMBER: RGBColor = RGBColor(230, 159, 0);
/// See [`BLUE`].
pub const SKY: RGBColor = RGBColor(86, 180, 233);
/// For lines that guide the eye.
pub const GREY: RGBColor = RGBColor(110, 110, 110);

/// Why a figure could not be written.
pub type DrawError = Box<dyn std::error::Error>;

/// Makes the font known, whatever the machine has.
pub fn fonts() -> Result<(), DrawError> {
    for (style, bytes) in [
        (FontStyle::Normal, dejavu::sans::regular()),
        (FontStyle::Bold, dejavu::sans::bold()),
    ] {
        plotters::style::register_font(FONT, style, bytes).map_err(|_| "the font is unreadable")?;
    }
    Ok(())
}
