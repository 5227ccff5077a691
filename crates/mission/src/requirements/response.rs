//! Responses before a requirement is violated.

/// Kind of response.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Response {
    /// Fly to the way out.
    TurnAway,
    /// Climb to the way out's altitude.
    Climb,
    /// Descend to the way out's altitude.
    Descend,
    /// Fly to the way out, which is a landing place, and land there.
    LandAt,
    /// Like [`Response::LandAt`], at another landing place than the base, because the vehicle cannot reach the base in time.
    LandElsewhere,
    /// Land at the present position.
    LandHere,
    /// Point a camera away from the ground.
    Stow,
    /// Switch a camera off until its detector is cool.
    Cool,
}

impl Response {
    /// Returns the response's word in messages.
    pub fn word(self) -> &'static str {
        match self {
            Response::TurnAway => "turn-away",
            Response::Climb => "climb",
            Response::Descend => "descend",
            Response::LandAt => "land-at",
            Response::LandElsewhere => "land-elsewhere",
            Response::LandHere => "land-here",
            Response::Stow => "stow",
            Response::Cool => "cool",
        }
    }
}
