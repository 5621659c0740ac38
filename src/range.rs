//! Ranges of parameters: which value is out of its range, by name.

/// A parameter outside its range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutOfRange {
    /// Name of the parameter.
    pub name: &'static str,
    /// Its value.
    pub value: f32,
    /// Smallest permitted value.
    pub min: f32,
    /// Largest permitted value.
    pub max: f32,
}

/// Checks values, each with its name and the ends of its range; NaN is outside every range.
///
/// # Errors
/// The first value out of its range.
pub const fn check<const N: usize>(
    values: &[(&'static str, f32, f32, f32); N],
) -> Result<(), OutOfRange> {
    let mut at = 0;
    while at < N {
        let (name, value, min, max) = values[at];
        if !(value >= min && value <= max) {
            return Err(OutOfRange {
                name,
                value,
                min,
                max,
            });
        }
        at += 1;
    }
    Ok(())
}
