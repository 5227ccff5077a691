//! The words of `flight-phase`.

/// Values of `flight-phase`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Phase {
    Parked,
    TakingOff,
    Climbing,
    EnRoute,
    Joining,
    Line,
    Manoeuvring,
    Loitering,
    Hovering,
    Approaching,
    Landing,
    Gliding,
    Crashed,
}

impl Phase {
    /// Returns the published word.
    pub(crate) fn word(self) -> &'static str {
        match self {
            Phase::Parked => "parked",
            Phase::TakingOff => "taking-off",
            Phase::Climbing => "climbing",
            Phase::EnRoute => "en-route",
            Phase::Joining => "joining",
            Phase::Line => "line",
            Phase::Manoeuvring => "manoeuvring",
            Phase::Loitering => "loitering",
            Phase::Hovering => "hovering",
            Phase::Approaching => "approaching",
            Phase::Landing => "landing",
            Phase::Gliding => "gliding",
            Phase::Crashed => "crashed",
        }
    }
}
