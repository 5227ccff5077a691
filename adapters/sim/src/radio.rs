//! Radio links: signal level by distance, shadow, fading and drop-outs.

use crate::config::Modem;
use crate::random::{Random, Wander};
use apex_geo::link::FULL_LEVEL_DB;
use apex_model::problem::Position;

/// A link counts as lost if its level is below `LOST_LEVEL` for `SETTLED_S`, as regained if it is above `REGAINED_LEVEL` for as long.
const LOST_LEVEL: f64 = 0.05;
const REGAINED_LEVEL: f64 = 0.15;
const SETTLED_S: f64 = 5.0;
/// Correlation time of fading.
const FADING_S: f64 = 4.0;

/// State of one radio link.
#[derive(Clone, Debug)]
pub(crate) struct Radio {
    pub(crate) modem: Modem,
    fading: Wander,
    /// 0 nothing .. 1 full.
    pub(crate) level: f64,
    /// The modem has failed.
    pub(crate) silenced: bool,
    lost: bool,
    /// Time for which the level has contradicted `lost`.
    contrary_s: f64,
}

/// Change of a link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LinkChange {
    Lost,
    Regained,
}

impl Radio {
    pub(crate) fn new(modem: Modem, seed: u64, index: u64) -> Radio {
        let fading = Wander::new(Random::new(seed, 100 + index), FADING_S);
        Radio { modem, fading, level: 1.0, silenced: false, lost: false, contrary_s: 0.0 }
    }

    /// Draws fading from another seed from now on; the state of the link stays.
    pub(crate) fn reseed(&mut self, seed: u64, index: u64) {
        self.fading = Radio::new(self.modem.clone(), seed, index).fading;
    }

    /// Samples the level at a place and time, `elapsed_s` after the last sample; returns the change of the link, if any.
    pub(crate) fn listen(&mut self, here: Position, altitude_m: f64, now_s: f64, elapsed_s: f64) -> Option<LinkChange> {
        let fading_db = self.modem.fading_db * self.fading.after(elapsed_s);
        let silent =
            self.silenced || self.modem.dropouts_s.iter().any(|(from_s, until_s)| *from_s <= now_s && now_s < *until_s);
        let level = self.modem.level.level(here, altitude_m);
        // Fading cannot restore a signal lost to distance or a shadow.
        let heard = if silent || level <= 0.0 { 0.0 } else { level - fading_db / FULL_LEVEL_DB };
        self.level = heard.clamp(0.0, 1.0);
        let contrary = if self.lost { self.level > REGAINED_LEVEL } else { self.level < LOST_LEVEL };
        if !contrary {
            self.contrary_s = 0.0;
            return None;
        }
        self.contrary_s += elapsed_s;
        if self.contrary_s < SETTLED_S {
            return None;
        }
        self.contrary_s = 0.0;
        self.lost = !self.lost;
        Some(if self.lost { LinkChange::Lost } else { LinkChange::Regained })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_geo::geodesy;

    #[test]
    fn the_level_falls_with_distance_and_the_link_is_lost_and_regained() {
        let station = Position::new(36.0, -121.0);
        let mut modem = Modem::at_station("900MHzModem", station, 500.0);
        modem.fading_db = 0.0;
        let mut radio = Radio::new(modem, 1, 0);
        let near = geodesy::destination(station, 90.0, 1_000.0);
        let far = geodesy::destination(station, 90.0, 40_000.0);
        assert_eq!(radio.listen(near, 100.0, 0.0, 1.0), None);
        let near_level = radio.level;
        assert!((0.7..0.95).contains(&near_level), "{near_level}");
        let changes: Vec<_> = (0..10).filter_map(|second| radio.listen(far, 100.0, f64::from(second), 1.0)).collect();
        assert_eq!((changes, radio.level), (vec![LinkChange::Lost], 0.0));
        let changes: Vec<_> = (0..10).filter_map(|second| radio.listen(near, 100.0, f64::from(second), 1.0)).collect();
        assert_eq!(changes, vec![LinkChange::Regained]);
    }

    #[test]
    fn a_drop_out_silences_a_satellite_link() {
        let mut modem = Modem::satellite("ku-band");
        modem.dropouts_s = vec![(10.0, 20.0)];
        let mut radio = Radio::new(modem, 1, 0);
        radio.listen(Position::new(0.0, 0.0), 0.0, 15.0, 1.0);
        assert_eq!(radio.level, 0.0);
        radio.listen(Position::new(0.0, 0.0), 0.0, 20.0, 1.0);
        assert!(radio.level > 0.9);
    }
}
