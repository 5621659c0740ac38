//! A candidate: a named function whose errors are measured by its caller.

/// What a candidate is to the firmware.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// The firmware or the library runs it: where, and why it was chosen.
    Used(&'static str),
    /// It checks what the firmware runs: where. It competes with nothing.
    Check(&'static str),
    /// It competes with what the firmware runs.
    Rival,
}

/// One way to do a task. All candidates of a task take the same input and promise the same output.
pub struct Candidate<I: 'static, O: 'static> {
    /// Name in the report.
    pub name: &'static str,
    /// The function. It stands alone (it is never inlined into the harness), so that its symbol has a size.
    pub run: fn(&I) -> O,
    /// What it is to the firmware.
    pub role: Role,
}

impl<I, O> Candidate<I, O> {
    /// One that the firmware or the library runs.
    pub const fn used(name: &'static str, run: fn(&I) -> O, why: &'static str) -> Self {
        let role = Role::Used(why);
        Self { name, run, role }
    }

    /// One that checks what the firmware runs.
    pub const fn check(name: &'static str, run: fn(&I) -> O, why: &'static str) -> Self {
        let role = Role::Check(why);
        Self { name, run, role }
    }

    /// The library's bisection for a place.
    pub const fn bisection(run: fn(&I) -> O) -> Self {
        let why = "Mechanics::locate, where every fit of sensing starts: the bisection that was asked for, with a bounded residual";
        Self::used("library_bisection", run, why)
    }

    /// The library's closed form for a place.
    pub const fn closed_form(run: fn(&I) -> O) -> Self {
        let why = "Mechanics::locate_closed, what tests and this report check the bisection with";
        Self::check("library_closed", run, why)
    }

    /// One that competes.
    pub const fn rival(name: &'static str, run: fn(&I) -> O) -> Self {
        let role = Role::Rival;
        Self { name, run, role }
    }
}

/// Contact locations on one phalanx, in the unit of its length; NaN where there is none. Their order means nothing.
pub type Roots = [f32; 2];

/// No location.
pub const NOWHERE: Roots = [f32::NAN; 2];

/// Keeps what lies on the phalanx: 0 < k <= length.
#[inline(always)]
pub fn on_phalanx(k: f32, length: f32) -> f32 {
    if k > 0.0 && k <= length { k } else { f32::NAN }
}
