// SPDX-License-Identifier: GPL-2.0-only
//! The floating-point unit.

use super::super::access::Bus;
use super::super::op::Op;
use super::super::translate::Code;
use super::{At, Ended, Handler, Step, handlers, r, s};

pub(super) const SIGN: u32 = 1 << 31;

macro_rules! float {
    ($bus:ident, $operation:ident, $d:expr, $n:expr, $m:expr) => {{
        let (n, m) = (s!($bus, $n), s!($bus, $m));
        s!($bus, $d) = $bus.registers.fpu.$operation(n, m);
    }};
}

/// Sum of a product and the destination, rounded twice, with the signs of the two.
macro_rules! chained {
    ($bus:ident, $d:expr, $n:expr, $m:expr, $product:expr, $addend:expr) => {{
        let (n, m, d) = (s!($bus, $n), s!($bus, $m), s!($bus, $d));
        let product = $bus.registers.fpu.mul(n, m) ^ $product;
        s!($bus, $d) = $bus.registers.fpu.add(d ^ $addend, product);
    }};
}

/// What executes an operation, if it is one of these.
pub(super) fn handler(op: Op) -> Option<Handler> {
    handlers! { plain op, bus, at;
        Op::VmovPairToS(d, t, t2) => (s!(bus, d), s!(bus, d + 1)) = (r!(bus, t), r!(bus, t2)),
        Op::VmovPairToR(d, t, t2) => (r!(bus, t), r!(bus, t2)) = (s!(bus, d), s!(bus, d + 1)),
        Op::Vsqrt(d, m) => {
                let m = s!(bus, m);
                s!(bus, d) = bus.registers.fpu.sqrt(m);
            },
        Op::Vadd(d, n, m) => float!(bus, add, d, n, m),
        Op::Vsub(d, n, m) => float!(bus, sub, d, n, m),
        Op::Vmul(d, n, m) => float!(bus, mul, d, n, m),
        Op::Vnmul(d, n, m) => {
                let (n, m) = (s!(bus, n), s!(bus, m));
                s!(bus, d) = bus.registers.fpu.mul(n, m) ^ SIGN;
            },
        Op::Vdiv(d, n, m) => float!(bus, div, d, n, m),
        Op::Vmla(d, n, m) => chained!(bus, d, n, m, 0, 0),
        Op::Vmls(d, n, m) => chained!(bus, d, n, m, SIGN, 0),
        Op::Vnmla(d, n, m) => chained!(bus, d, n, m, SIGN, SIGN),
        Op::Vnmls(d, n, m) => chained!(bus, d, n, m, 0, SIGN),
        Op::Vfma(d, n, m, negate, negate_first) => {
                let sign = |negate| if negate { SIGN } else { 0 };
                let (a, b, c) = (s!(bus, n) ^ sign(negate_first), s!(bus, m), s!(bus, d) ^ sign(negate));
                s!(bus, d) = bus.registers.fpu.fused(a, b, c);
            },
        Op::Vcmp(d, m, signals) => {
                let (d, m) = (s!(bus, d), s!(bus, m));
                bus.registers.fpu.compare(d, m, signals);
            },
        Op::VcmpZero(d, signals) => {
                let d = s!(bus, d);
                bus.registers.fpu.compare(d, 0, signals);
            },
        Op::Vcvt(kind, d, m, fraction) => {
                s!(bus, d) = bus.registers.fpu.convert(kind, s!(bus, m), fraction)
            },
        Op::Vmrs(t) => r!(bus, t) = bus.registers.fpu.status(),
        Op::Vmsr(t) => {
                let status = r!(bus, t);
                bus.registers.fpu.set_status(status);
            },
        Op::VcmpFlags(d, m, signals) => bus.registers.compare(s!(bus, d), s!(bus, m), signals),
        Op::VcmpZeroFlags(d, signals) => bus.registers.compare(s!(bus, d), 0, signals),
    }
}
