//! Margin of a data link.

/// Returns the margin in dB: received power above the sensitivity of the receiver and an allowance for fading.
pub fn link_db(received_dbm: f64, sensitivity_dbm: f64, fade_db: f64) -> f64 {
    received_dbm - sensitivity_dbm - fade_db
}

/// Returns the margin in seconds: a loss may last `allowed_s`.
pub fn loss_s(lost_for_s: f64, allowed_s: f64) -> f64 {
    allowed_s - lost_for_s
}
