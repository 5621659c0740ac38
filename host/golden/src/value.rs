//! Recomputed values of a row, and their deviation from the file.

use crate::real::Real;

/// `prefix1suffix`, `prefix2suffix` and so on.
pub fn joint_names(prefix: &str, suffix: &str) -> impl Iterator<Item = String> {
    (1..).map(move |joint| format!("{prefix}{joint}{suffix}"))
}

/// A cell.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// Rounded to f64; not a number where undefined.
    Number(f64),
    /// As it is written.
    Text(String),
}

/// Below this a number is the rounding of zero: derivatives are exact to some 36 digits.
const ZERO: f64 = 1e-30;

impl Value {
    /// As the files write it.
    #[must_use]
    pub fn written(&self) -> String {
        match self {
            Self::Text(text) => text.clone(),
            Self::Number(value) if value.is_nan() => "nan".to_owned(),
            Self::Number(value) if value.is_infinite() => "inf".to_owned(),
            Self::Number(value) if *value == 0.0 => "0.0".to_owned(),
            // The shortest text that reads back as the same number, as in the files.
            Self::Number(value) if (1e-4..1e16).contains(&value.abs()) => format!("{value:?}"),
            Self::Number(value) => exponential(*value),
        }
    }

    /// Difference to what stands in a file, relative; infinite where one is defined and the other is not.
    #[must_use]
    pub fn deviation(&self, cell: &str) -> f64 {
        let wrong = |wrong: bool| if wrong { f64::INFINITY } else { 0.0 };
        let own = match self {
            Self::Text(text) => return wrong(text != cell),
            Self::Number(value) => *value,
        };
        let Ok(there) = cell.parse::<f64>() else {
            return f64::INFINITY;
        };
        if own.is_nan() || there.is_nan() {
            return wrong(own.is_nan() != there.is_nan());
        }
        if own == there || own.abs().max(there.abs()) < ZERO {
            return 0.0;
        }
        if there.is_infinite() {
            return f64::INFINITY;
        }
        (own - there).abs() / there.abs()
    }
}

/// With a sign and two digits in the exponent.
fn exponential(value: f64) -> String {
    let text = format!("{value:e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let sign = if exponent < 0 { '-' } else { '+' };
    format!("{mantissa}e{sign}{:02}", exponent.abs())
}

/// The recomputed cells of a row; columns that are not among them are inputs.
#[derive(Clone, Debug, Default)]
pub struct Values(Vec<(String, Value)>);

impl Values {
    /// None yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// A number.
    pub fn number(&mut self, name: &str, value: &Real) {
        let value = value.to_f64();
        let value = if value.abs() < ZERO { 0.0 } else { value };
        self.0.push((name.to_owned(), Value::Number(value)));
    }

    /// A number that is not defined.
    pub fn absent(&mut self, name: &str) {
        self.0.push((name.to_owned(), Value::Number(f64::NAN)));
    }

    /// A word or a count.
    pub fn text(&mut self, name: &str, value: impl ToString) {
        self.0
            .push((name.to_owned(), Value::Text(value.to_string())));
    }

    /// One number a joint.
    pub fn joints(&mut self, prefix: &str, suffix: &str, values: &[Real]) {
        for (name, value) in joint_names(prefix, suffix).zip(values) {
            self.number(&name, value);
        }
    }

    /// The transmission row without its first entry, which is 1.
    pub fn transmission(&mut self, row: &[Real]) {
        for (name, value) in joint_names("x", "").zip(row).skip(1) {
            self.number(&name, value);
        }
    }

    /// Cells by the name of their column.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &Value)> {
        self.0.iter().map(|(name, value)| (name.as_str(), value))
    }

    /// The cell of a column, where it is an output.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&Value> {
        self.iter()
            .find(|(column, _)| *column == name)
            .map(|(_, value)| value)
    }
}

#[cfg(test)]
mod tests {
    use super::Value;

    #[test]
    fn numbers_are_written_and_compared_as_in_the_files() {
        let written = |value| Value::Number(value).written();
        assert_eq!(
            [
                written(0.5),
                written(9.45e-5),
                written(f64::NAN),
                written(2.0)
            ],
            ["0.5", "9.45e-05", "nan", "2.0"]
        );
        assert_eq!(Value::Number(1.0).deviation("1.0"), 0.0);
        assert!(Value::Number(1.0).deviation("1.0000000000000002") < 3e-16);
        assert!(Value::Number(1.0).deviation("nan").is_infinite());
        assert!(
            Value::Text("unique".to_owned())
                .deviation("proximal")
                .is_infinite()
        );
    }
}
