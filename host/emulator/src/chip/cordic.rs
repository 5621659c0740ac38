// SPDX-License-Identifier: GPL-2.0-only
//! CORDIC co-processor: sine and cosine of a unit vector in q1.31, with the precision of the reference manual instead of a model
//! of the circuit.
//!
//! With 6 cycles the manual gives a residual error of at most 2^-19. The low bits are not published; here the exact value is
//! rounded down to a multiple of 2^-19, so that users of the model see an error of the documented size.
//! On the chip a read waits for the result; here it takes no time.

use super::bank::{Bank, Misuse};

const CSR: u32 = 0x00;
const WDATA: u32 = 0x04;
const RDATA: u32 = 0x08;

/// CSR.RRDY: a result is ready.
const READY: u32 = 1 << 31;
/// CSR: function cosine, 6 cycles, no scale, two results, one argument, words of 32 bits.
const COSINE_SINE: u32 = 6 << 4 | 1 << 19;
/// Bits of a result in q1.31 that lie below 2^-19.
const BELOW: i64 = 1 << (31 - 19);

/// The co-processor.
#[derive(Debug)]
pub(super) struct Cordic {
    bank: Bank,
    /// Results not read yet, the next one last.
    results: Vec<u32>,
}

/// In q1.31, rounded down to the documented precision; 1 has no representation.
fn promised(value: f64) -> u32 {
    let exact = value * f64::from(1u32 << 31);
    let kept = (exact / BELOW as f64).floor() as i64 * BELOW;
    kept.clamp(i32::MIN.into(), i32::MAX.into()) as i32 as u32
}

impl Cordic {
    pub(super) fn new() -> Self {
        Self {
            bank: Bank::new(
                "CORDIC",
                &[(CSR, "CSR", 0x50), (WDATA, "WDATA", 0), (RDATA, "RDATA", 0)],
            ),
            results: Vec::new(),
        }
    }

    pub(super) fn reset(&mut self) {
        *self = Self::new();
    }

    pub(super) fn read(&mut self, offset: u32) -> Result<u32, Misuse> {
        match offset {
            CSR if !self.results.is_empty() => Ok(self.bank[CSR] | READY),
            RDATA => self.results.pop().ok_or_else(|| {
                self.bank
                    .unsupported(RDATA, 0, "there is no result to read")
            }),
            _ => self.bank.read(offset),
        }
    }

    pub(super) fn write(&mut self, offset: u32, value: u32) -> Result<(), Misuse> {
        match offset {
            CSR if value & !READY != COSINE_SINE => {
                let what = "only cosine and sine of one argument, 6 cycles, both results, 32 bits are modelled";
                return Err(self.bank.unsupported(CSR, value, what));
            }
            WDATA => {
                if self.bank[CSR] != COSINE_SINE {
                    let what = "an argument before the function was chosen (CSR)";
                    return Err(self.bank.unsupported(WDATA, value, what));
                }
                // The angle is in units of pi.
                let rad = f64::from(value as i32) / f64::from(1u32 << 31) * std::f64::consts::PI;
                self.results = vec![promised(rad.sin()), promised(rad.cos())];
            }
            RDATA => {
                return Err(self
                    .bank
                    .unsupported(RDATA, value, "results cannot be written"));
            }
            _ => {}
        }
        self.bank.write(
            offset,
            value & if offset == CSR { !READY } else { u32::MAX },
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(angle: i32) -> (f64, f64) {
        let mut cordic = Cordic::new();
        cordic.write(CSR, COSINE_SINE).unwrap();
        cordic.write(WDATA, angle as u32).unwrap();
        assert_eq!(cordic.read(CSR).unwrap() & READY, READY);
        let mut result = || f64::from(cordic.read(RDATA).unwrap() as i32) / f64::from(1u32 << 31);
        let (cos, sin) = (result(), result());
        assert!(cordic.read(RDATA).is_err(), "two results, no third");
        (cos, sin)
    }

    #[test]
    fn keeps_the_documented_error_all_round() {
        let (mut worst, limit) = (0.0f64, 2f64.powi(-19));
        for at in -500..500 {
            let angle = at * (i32::MAX / 500);
            let rad = f64::from(angle) / f64::from(1u32 << 31) * std::f64::consts::PI;
            let (cos, sin) = asked(angle);
            worst = worst
                .max((cos - rad.cos()).abs())
                .max((sin - rad.sin()).abs());
        }
        assert!(
            worst <= limit && worst > 0.9 * limit,
            "{worst:e} of {limit:e}"
        );
    }

    #[test]
    fn what_is_not_modelled_is_refused() {
        let mut cordic = Cordic::new();
        assert!(cordic.write(WDATA, 0).is_err(), "no function chosen");
        assert!(cordic.write(CSR, COSINE_SINE | 1).is_err(), "sine first");
        assert!(
            cordic.write(CSR, COSINE_SINE & !0xF0).is_err(),
            "another precision"
        );
        assert!(cordic.write(RDATA, 0).is_err());
        assert!(cordic.read(RDATA).is_err());
    }
}
