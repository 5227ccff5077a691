//! Changes to a world in the middle of a flight, for what-if questions.

use crate::world::SimulatedWorld;
use apex_model::problem::WindField;

impl SimulatedWorld {
    /// Replaces the wind from now on. The vehicle's motion is as before.
    pub fn change_wind(&mut self, wind: WindField) {
        self.wind_field = wind;
        self.settled = false;
    }

    /// Draws turbulence and fading of radio links from the streams of `seed` from now on.
    pub fn reseed(&mut self, seed: u64) {
        self.turbulence.reseed(seed);
        for (radio, index) in self.radios.iter_mut().zip(0_u64..) {
            radio.reseed(seed, index);
        }
        self.settled = false;
    }
}
