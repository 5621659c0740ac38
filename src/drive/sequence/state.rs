//! The states of the motion sequence, their legal transitions and their timeouts.

/// What the finger is doing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub enum State {
    /// At rest, bridge off.
    #[default]
    Idle,
    /// Measuring the offset of the current sense at standstill.
    CalibrateOffset,
    /// Opening against the stop to find the encoder's zero.
    Home,
    /// Closing free over the whole travel, recording friction.
    RecordClosing,
    /// Opening again, recording friction.
    RecordOpening,
    /// Closing until contact.
    Close,
    /// Closing on after contact, the torque rising.
    Probe,
    /// Holding the object with the commanded current.
    Hold,
    /// Opening to the rest position.
    Open,
    /// Bridge off until cleared.
    Fault,
}

impl State {
    /// Every state.
    pub const ALL: [State; 10] = [
        State::Idle,
        State::CalibrateOffset,
        State::Home,
        State::RecordClosing,
        State::RecordOpening,
        State::Close,
        State::Probe,
        State::Hold,
        State::Open,
        State::Fault,
    ];

    /// Name, as logged.
    pub const fn name(self) -> &'static str {
        match self {
            State::Idle => "idle",
            State::CalibrateOffset => "calibrate-offset",
            State::Home => "home",
            State::RecordClosing => "record-closing",
            State::RecordOpening => "record-opening",
            State::Close => "close",
            State::Probe => "probe",
            State::Hold => "hold",
            State::Open => "open",
            State::Fault => "fault",
        }
    }

    /// The states that may follow this one. `Idle` (stop) and `Fault` may follow every moving state.
    pub const fn successors(self) -> &'static [State] {
        use State::*;
        match self {
            Idle => &[CalibrateOffset, Home, RecordClosing, Close, Open, Fault],
            CalibrateOffset => &[Home, Idle, Fault],
            Home => &[RecordClosing, Close, Open, Idle, Fault],
            RecordClosing => &[RecordOpening, Idle, Fault],
            RecordOpening => &[Close, Idle, Fault],
            Close => &[Probe, Hold, Open, Idle, Fault],
            Probe => &[Hold, Open, Idle, Fault],
            Hold => &[Open, Close, Idle, Fault],
            Open => &[Close, RecordClosing, Idle, Fault],
            Fault => &[Idle],
        }
    }

    /// Whether `next` may follow.
    pub fn may_become(self, next: State) -> bool {
        self.successors().contains(&next)
    }
}
