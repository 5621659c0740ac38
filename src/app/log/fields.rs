//! Lines as keys and values, for programs that write them in another form than defmt's.

use super::{Level, Line, Log};
use crate::log_lines;

/// A value of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value<'a> {
    /// Text.
    Text(&'a str),
    /// A quantity; NaN where it is not known.
    Number(f32),
    /// A count or a time.
    Count(i64),
    /// Yes or no.
    Flag(bool),
}

impl<'a> From<&'a str> for Value<'a> {
    fn from(text: &'a str) -> Self {
        Self::Text(text)
    }
}

impl From<f32> for Value<'_> {
    fn from(number: f32) -> Self {
        Self::Number(number)
    }
}

impl From<bool> for Value<'_> {
    fn from(flag: bool) -> Self {
        Self::Flag(flag)
    }
}

macro_rules! counts {
    ($($type:ty)*) => {
        $(impl From<$type> for Value<'_> {
            fn from(count: $type) -> Self {
                Self::Count(count as i64)
            }
        })*
    };
}
counts!(u8 i8 u16 u32 i32 u64);

/// A log that calls a function with every line and its values, in the order of the line's keys.
pub struct Fields<F>(pub F);

macro_rules! implement {
    ($($(#[$doc:meta])* $function:ident $level:ident $format:literal ($($key:ident: $type:ty),*);)*) => {
        impl<F: FnMut(&'static Line, &[Value<'_>])> Log for Fields<F> {
            $(fn $function(&mut self, $($key: $type),*) {
                const LINE: &Line = &Line {
                    level: Level::$level,
                    format: $format,
                    keys: &[$(stringify!($key)),*],
                };
                (self.0)(LINE, &[$(Value::from($key)),*]);
            })*
        }
    };
}
log_lines!(implement);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::log::event;
    use crate::sensing::Event;

    #[test]
    fn an_event_becomes_its_line_in_the_log_s_units() {
        let mut seen = Vec::new();
        let mut log = Fields(|line: &'static Line, values: &[Value<'_>]| {
            let values = values.iter().map(|value| format!("{value:?}"));
            seen.push((line.name(), line.keys, values.collect::<Vec<_>>()));
        });
        let touch = Event::Touch {
            time_us: 7,
            theta_a_rad: 0.5,
            torque_nm: 0.25,
        };
        event(&mut log, &touch);
        let keys: &[&str] = &["time_us", "theta_a_mrad", "torque_mnm"];
        let values = ["Count(7)", "Number(500.0)", "Number(250.0)"];
        assert_eq!(seen, [("touch", keys, values.map(String::from).to_vec())]);
    }
}
