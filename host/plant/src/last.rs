//! Caches the value of a function at its last argument: much of the simulated world rests most of the time.

/// A function's last argument and its value there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Last {
    at: f64,
    value: f64,
}

impl Last {
    /// Before the first argument.
    pub fn new() -> Self {
        let at = f64::NAN;
        Self { at, value: at }
    }

    /// The value at a number of the function, which must be the same every time.
    pub fn of(&mut self, at: f64, function: impl FnOnce() -> f64) -> f64 {
        if self.at.to_bits() != at.to_bits() {
            *self = Self {
                at,
                value: function(),
            };
        }
        self.value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_computes_once_for_a_number() {
        let (mut last, mut computed) = (Last::new(), 0);
        let found = [1.0, 1.0, 2.0, 2.0, 1.0, 0.0, -0.0].map(|at| {
            last.of(at, || {
                computed += 1;
                10.0 * at
            })
        });
        assert_eq!(found, [10.0, 10.0, 20.0, 20.0, 10.0, 0.0, 0.0]);
        assert_eq!(computed, 5);
    }
}
