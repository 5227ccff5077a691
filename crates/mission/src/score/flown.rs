//! The fold over the batches of a flight.

use super::samples::Latest;
use crate::observing::{NoTerrain, scanner_of};
use crate::{Mission, TargetKind};
use apex_model::event::{Batch, EventKind};
use apex_model::time::Time;
use apex_observation::flown::{FlightSample, FlownObservation, FlownSettings, SensorState};
use apex_observation::grid::GridSettings;
use apex_observation::result::TargetResult;
use apex_observation::strip::ScannerSetting;

/// Longest time between two samples across which the ground counts as seen.
const SAMPLE_GAP_S_MAX: f64 = 2.5;

/// What has been observed so far: a fold over the batches of a flight.
#[derive(Clone)]
pub struct FlownScore {
    observation: FlownObservation,
    ground: NoTerrain,
    /// What the scanner is set to while it is on; none: the vehicle carries none.
    scanner: Option<ScannerSetting>,
    latest: Latest,
}

/// What has been observed, or why nothing is known of it.
pub(crate) fn told(flown: &Result<Option<FlownScore>, String>) -> Result<&FlownScore, &str> {
    match flown {
        Ok(Some(flown)) => Ok(flown),
        Ok(None) => Err("the mission wants no observations"),
        Err(why) => Err(why),
    }
}

impl FlownScore {
    /// Nothing observed yet; none for a mission without targets of single visits.
    ///
    /// # Errors
    /// The ground of a target makes no sense.
    pub fn new(mission: &Mission) -> Result<Option<FlownScore>, String> {
        let wanted = mission.targets.iter().filter_map(|target| match &target.kind {
            TargetKind::Fire(fire) => Some(fire.wanted.clone()),
            TargetKind::Site(_) | TargetKind::Plain | TargetKind::Base => None,
        });
        let wanted: Vec<_> = wanted.collect();
        if wanted.is_empty() {
            return Ok(None);
        }
        let lowest_m = wanted.iter().map(|target| target.elevation_m).fold(f64::INFINITY, f64::min);
        let (scanner, ground) = (scanner_of(&mission.model), NoTerrain { lowest_m });
        let settings = FlownSettings {
            zero_unix_s: mission.settings.epoch_unix_s.unwrap_or(0.0),
            grid: GridSettings::default(),
            sample_gap_s_max: SAMPLE_GAP_S_MAX,
        };
        let observation = FlownObservation::new(wanted, settings, &ground).map_err(|error| error.to_string())?;
        let scanner = scanner.map(|scanner| scanner.setting);
        Ok(Some(FlownScore { observation, ground, scanner, latest: Latest::default() }))
    }

    /// Takes the measurements of a batch of the agent that flies.
    pub fn observe(&mut self, batch: &Batch) {
        let mut pending: Option<Time> = None;
        for event in &batch.events {
            let EventKind::Measurement(variable, value) = &event.kind else { continue };
            if pending.is_some_and(|at| at != event.at) {
                self.sample(pending.take());
            }
            let attribute = variable.attribute.folded();
            let was_on = self.latest.is_on;
            if self.latest.take(attribute, value, event.at) {
                pending = Some(event.at);
            }
            match (was_on, self.latest.is_on) {
                (false, true) => self.switch(),
                (true, false) => {
                    // The last sample still belongs to the line.
                    self.latest.is_on = true;
                    self.sample(pending.take());
                    self.latest.is_on = false;
                    self.switch();
                }
                _ => {}
            }
        }
        self.sample(pending);
    }

    /// The scanner was switched.
    fn switch(&mut self) {
        let state = match &self.scanner {
            Some(setting) if self.latest.is_on => SensorState::Scanning(setting.clone()),
            _ => SensorState::Off,
        };
        self.observation.sensor(state);
    }

    fn sample(&mut self, at: Option<Time>) {
        let Some(at) = at.filter(|_| self.latest.is_on) else { return };
        let Some((position, altitude_m)) = self.latest.place else { return };
        let sample = FlightSample {
            time_s: at.seconds(),
            position,
            altitude_m,
            attitude: self.latest.attitude(at),
            ground_speed_mps: self.latest.ground_speed_mps(at),
            clear_share: self.latest.clear_share,
        };
        self.observation.sample(sample, &self.ground);
    }

    /// What has been seen so far.
    pub(crate) fn observation(&self) -> &FlownObservation {
        &self.observation
    }

    /// What each target's looks have come to.
    pub fn results(&self) -> Vec<TargetResult> {
        self.observation.results()
    }
}
