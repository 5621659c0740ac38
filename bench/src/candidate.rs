//! A candidate: a named function with its error measure left to whoever judges it.

/// One way to do a task. All candidates of a task take the same input and promise the same output.
pub struct Candidate<I: 'static, O: 'static> {
    /// Name in the report.
    pub name: &'static str,
    /// The function. It stands alone (it is never inlined into the harness), so that its symbol has a size.
    pub run: fn(&I) -> O,
    /// Where the firmware uses it, and why it was chosen; nothing for a method that it does not use.
    pub chosen: Option<&'static str>,
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
