// SPDX-License-Identifier: GPL-2.0-only
//! Functions for several operations at once: what they do as types, which the compiler puts together.
//!
//! A jump from function to function is predicted from those before it, and a processor keeps some thousand such predictions: fewer
//! than the operations of the firmware's control interrupt. Two operations a jump halve their number.

use std::marker::PhantomData;

use super::super::access::Bus;
use super::super::op::Op;
use super::super::translate::Code;
use super::{At, Ended, Handler, Step};

/// The operations behind an action, or how it ended the block.
pub(super) type Then<'a> = Result<&'a [Step], Ended>;

/// What an operation does, or several of them.
pub(super) trait Action {
    /// `op` is the first operation, `rest` those behind it.
    fn act<'a>(bus: &mut Bus, op: Op, rest: &'a [Step], code: &Code) -> Then<'a>;
}

/// An action whose result goes into one register.
pub(super) trait Assign: Action {
    /// Acts if `holds`; otherwise the register keeps its value. Without a branch: which of the two it is may be as random as the
    /// numbers.
    fn assign(bus: &mut Bus, op: Op, holds: bool);
}

/// One action after the other.
pub(super) struct Two<A, B>(A, B);

impl<A: Action, B: Action> Action for Two<A, B> {
    #[inline(always)]
    fn act<'a>(bus: &mut Bus, op: Op, rest: &'a [Step], code: &Code) -> Then<'a> {
        let rest = A::act(bus, op, rest, code)?;
        match rest.split_first() {
            Some((step, rest)) => B::act(bus, step.op, rest, code),
            None => Err(Ended::Next),
        }
    }
}

/// [`Op::If`] and the one operation that it decides about.
pub(super) struct When<A>(A);

impl<A: Assign> Action for When<A> {
    #[inline(always)]
    fn act<'a>(bus: &mut Bus, op: Op, rest: &'a [Step], _: &Code) -> Then<'a> {
        let (Op::If(condition, _), Some((step, rest))) = (op, rest.split_first()) else {
            return Err(Ended::Next);
        };
        let holds = bus.registers.holds(condition);
        A::assign(bus, step.op, holds);
        Ok(rest)
    }
}

/// Leaves operations out unless a condition holds.
pub(super) struct If;

impl Action for If {
    #[inline(always)]
    fn act<'a>(bus: &mut Bus, op: Op, rest: &'a [Step], _: &Code) -> Then<'a> {
        let Op::If(condition, skip) = op else {
            return Err(Ended::Next);
        };
        if bus.registers.holds(condition) {
            Ok(rest)
        } else {
            Ok(rest.get(usize::from(skip)..).unwrap_or_default())
        }
    }
}

/// The next stretch begins.
pub(super) struct Seam;

impl Action for Seam {
    #[inline(always)]
    fn act<'a>(bus: &mut Bus, op: Op, rest: &'a [Step], _: &Code) -> Then<'a> {
        bus.cross_by(op, rest)
    }
}

/// Executes an action and what comes behind it.
pub(super) fn run<A: Action>(bus: &mut Bus, op: Op, rest: &[Step], code: &Code) -> Ended {
    match A::act(bus, op, rest, code) {
        Ok(rest) => At { rest, code }.next(bus),
        Err(ended) => ended,
    }
}

/// What is selected for an action: a function that executes it.
pub(super) trait Select: Copy {
    fn of<A: Action>(self) -> Option<Handler>;
}

/// The action alone.
#[derive(Clone, Copy)]
pub(super) struct Alone;

impl Select for Alone {
    fn of<A: Action>(self) -> Option<Handler> {
        Some(run::<A>)
    }
}

/// The action behind another one.
pub(super) struct Behind<A>(pub(super) PhantomData<A>);

impl<A> Clone for Behind<A> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<A> Copy for Behind<A> {}

impl<A: Action> Select for Behind<A> {
    fn of<B: Action>(self) -> Option<Handler> {
        Some(run::<Two<A, B>>)
    }
}

/// Types of actions, and a function that selects by an operation. Plain actions go on, `quick` ones are left to
/// [`super::elsewhere`] if they end with `?`, `jumping` ones give the target if they jump and otherwise go on with the next stretch,
/// `crossing` ones do so always, `ending` ones say themselves how the block ended, `assign` ones give a register and its value; of
/// these `conditional` selects those that an [`Op::If`] decides about.
macro_rules! actions {
    (@plain $bus:ident, $op:ident, $rest:ident, $code:ident, $body:expr) => {{
        $body;
        Ok($rest)
    }};
    (@quick $bus:ident, $op:ident, $rest:ident, $code:ident, $body:expr) => {{
        let mut done = || -> Option<()> {
            $body;
            Some(())
        };
        match done() {
            Some(()) => Ok($rest),
            None => Err(elsewhere($bus, $op, $rest, $code)),
        }
    }};
    (@jumping $bus:ident, $op:ident, $rest:ident, $code:ident, $body:expr) => {
        match $body {
            Some(target) => Err($bus.jump(target)),
            None => $bus.cross($rest),
        }
    };
    (@crossing $bus:ident, $op:ident, $rest:ident, $code:ident, $body:expr) => {{
        $body;
        $bus.cross($rest)
    }};
    (@ending $bus:ident, $op:ident, $rest:ident, $code:ident, $body:expr) => {
        Err($body)
    };
    (assign $select:ident, $conditional:ident, $bus:ident; $($name:ident: $pattern:pat => $place:ident $d:ident = $body:expr,)+) => {
        actions! { plain $select, $bus, code; $($name: $pattern => $place!($bus, $d) = $body,)+ }

        #[allow(unused_variables, reason = "of the patterns, the actions use them")]
        fn $conditional(op: Op, select: impl Select) -> Option<Handler> {
            match op {
                $($pattern => select.of::<When<$name>>(),)+
                _ => None,
            }
        }

        $(impl Assign for $name {
            #[inline(always)]
            fn assign($bus: &mut Bus, op: Op, holds: bool) {
                let $pattern = op else {
                    return;
                };
                let value = $body;
                $place!($bus, $d) = select_unpredictable(holds, value, $place!($bus, $d));
            }
        })+
    };
    ($kind:ident $select:ident, $bus:ident, $code:ident; $($name:ident: $pattern:pat => $body:expr,)+) => {
        #[allow(unused_variables, reason = "of the patterns, the actions use them")]
        fn $select(op: Op, select: impl Select) -> Option<Handler> {
            match op {
                $($pattern => select.of::<$name>(),)+
                _ => None,
            }
        }

        $(struct $name;

        impl Action for $name {
            #[inline(always)]
            #[allow(unused_variables, reason = "not every action needs its block")]
            fn act<'a>($bus: &mut Bus, op: Op, rest: &'a [Step], $code: &Code) -> Then<'a> {
                let $pattern = op else {
                    return Err(Ended::Next);
                };
                actions!(@$kind $bus, op, rest, $code, $body)
            }
        })+
    };
}
pub(super) use actions;
