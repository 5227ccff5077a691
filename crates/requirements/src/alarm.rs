//! Alarms: decides when a requirement is reported as threatened, and when as kept again.

use serde::{Deserialize, Serialize};

/// Protected good of a requirement, most important first: if several need a response, the first has precedence.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Concern {
    /// Clearance of the ground.
    Terrain,
    /// Energy to a landing place.
    Energy,
    /// Distance to a landing place.
    LandingDistance,
    /// Zones to keep out of, and areas to keep in.
    Airspace,
    /// Turbulence, wind, icing.
    Weather,
    /// The end of the mission.
    MissionEnd,
    /// The data link.
    Link,
    /// Sun and temperature of sensors.
    Sensor,
}

/// Margins at which an alarm is raised and cleared. The unit is that of the margin.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Thresholds {
    /// Below this margin the requirement is threatened, whatever the prediction says.
    pub warning: f64,
    /// Consecutive samples that must agree before an alarm is raised.
    pub raise_samples: u32,
    /// Share of `warning` by which the margin must exceed it before the alarm is cleared.
    pub clear_share: f64,
    /// Time for which the margin must exceed that, s, before the alarm is cleared.
    pub clear_s: f64,
}

impl Thresholds {
    /// Returns thresholds that raise after two samples below `warning`, and clear after 15 s above 1.2 times that.
    pub fn new(warning: f64) -> Thresholds {
        Thresholds { warning, raise_samples: 2, clear_share: 0.2, clear_s: 15.0 }
    }

    /// Returns the margin above which the requirement is clear.
    fn clear(&self) -> f64 {
        self.warning * (1.0 + self.clear_share)
    }
}

/// State of an alarm.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum AlarmState {
    /// The requirement is kept.
    #[default]
    Kept,
    /// A response is needed.
    Raised,
}

/// Alarms within this time are counted together.
const ESCALATION_S: f64 = 3600.0;
/// Number of alarms within [`ESCALATION_S`] above which the response is considered ineffective.
pub const ALARMS_PER_HOUR_MAX: usize = 3;

/// Time for which one alarm may last with the requirement violated, s, before the response is considered ineffective.
pub const VIOLATED_S_MAX: f64 = 1200.0;
/// Longest time between samples for which the earlier one counts, s.
const SAMPLE_GAP_S: f64 = 60.0;

/// Hysteresis of one requirement.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Alarm {
    state: AlarmState,
    /// Number of successive samples that request the alarm.
    asked: u32,
    /// Instant from which the margin has been clear, s of mission time; `None` while it is not clear or no alarm is raised.
    clear_since_s: Option<f64>,
    /// Instants at which alarms of the last hour were raised.
    raised_s: Vec<f64>,
    /// Time for which the requirement has been violated during the present alarm, s.
    violated_s: f64,
    /// Instant of the last sample, if the requirement was violated there.
    violated_at_s: Option<f64>,
}

/// One sample of a requirement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RequirementSample {
    /// Instant in seconds of mission time.
    pub at_s: f64,
    /// The margin now.
    pub margin: f64,
    /// True if the prediction requires a response now ([`crate::response::must_act`]).
    pub must_act: bool,
}

impl Alarm {
    /// Returns the state after the samples so far.
    pub fn state(&self) -> AlarmState {
        self.state
    }

    /// Processes a sample; returns the new state if it has changed.
    ///
    /// A prediction and a margin below the warning raise the alarm after the same number of samples; a violated requirement raises it at
    /// once.
    pub fn take(&mut self, sample: RequirementSample, thresholds: &Thresholds) -> Option<AlarmState> {
        let asks = sample.must_act || sample.margin < thresholds.warning;
        match self.state {
            AlarmState::Kept => {
                self.asked = if asks { self.asked.saturating_add(1) } else { 0 };
                if self.asked < thresholds.raise_samples && sample.margin >= 0.0 {
                    return None;
                }
                self.raise(sample.at_s);
            }
            AlarmState::Raised => {
                let since_s = self.violated_at_s.map_or(0.0, |before_s| sample.at_s - before_s);
                self.violated_s += since_s.clamp(0.0, SAMPLE_GAP_S);
                self.violated_at_s = (sample.margin < 0.0).then_some(sample.at_s);
                if asks || sample.margin <= thresholds.clear() {
                    self.clear_since_s = None;
                    return None;
                }
                let since_s = *self.clear_since_s.get_or_insert(sample.at_s);
                if sample.at_s - since_s < thresholds.clear_s {
                    return None;
                }
                *self = Alarm { raised_s: std::mem::take(&mut self.raised_s), ..Alarm::default() };
            }
        }
        Some(self.state)
    }

    fn raise(&mut self, at_s: f64) {
        self.raised_s.retain(|raised_s| at_s - raised_s < ESCALATION_S);
        self.raised_s.push(at_s);
        (self.state, self.asked, self.clear_since_s) = (AlarmState::Raised, 0, None);
    }

    /// Returns true if another response is needed: alarms were raised too often in the last hour, or the requirement has been violated for
    /// [`VIOLATED_S_MAX`] during the present alarm.
    pub fn is_escalated(&self) -> bool {
        self.raised_s.len() > ALARMS_PER_HOUR_MAX || self.violated_s >= VIOLATED_S_MAX
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn take(alarm: &mut Alarm, at_s: f64, margin: f64, must_act: bool) -> Option<AlarmState> {
        alarm.take(RequirementSample { at_s, margin, must_act }, &Thresholds::new(100.0))
    }

    #[test]
    fn two_samples_raise_and_a_lasting_clearance_clears() {
        let mut alarm = Alarm::default();
        assert_eq!(take(&mut alarm, 0.0, 90.0, false), None);
        assert_eq!(take(&mut alarm, 1.0, 110.0, false), None, "one sample was an outlier");
        assert_eq!(take(&mut alarm, 2.0, 90.0, false), None);
        assert_eq!(take(&mut alarm, 3.0, 90.0, false), Some(AlarmState::Raised));
        assert_eq!(take(&mut alarm, 4.0, 119.0, false), None, "below 1.2 of the warning");
        assert_eq!(take(&mut alarm, 5.0, 121.0, false), None);
        assert_eq!(take(&mut alarm, 19.0, 121.0, false), None);
        assert_eq!(take(&mut alarm, 20.0, 121.0, false), Some(AlarmState::Kept));
    }

    #[test]
    fn a_dip_starts_the_clearance_again() {
        let mut alarm = Alarm::default();
        assert_eq!(take(&mut alarm, 0.0, -1.0, false), Some(AlarmState::Raised), "a violation is not waited for");
        take(&mut alarm, 1.0, 200.0, false);
        take(&mut alarm, 10.0, 200.0, true);
        take(&mut alarm, 11.0, 200.0, false);
        assert_eq!(take(&mut alarm, 20.0, 200.0, false), None);
        assert_eq!(take(&mut alarm, 26.0, 200.0, false), Some(AlarmState::Kept));
    }

    /// A circle around a landing place that is too small for the vehicle passes through the permitted area and is never clear.
    #[test]
    fn an_alarm_escalates_after_twenty_minutes_of_violation() {
        let mut alarm = Alarm::default();
        take(&mut alarm, 0.0, -1.0, false);
        for at_s in (10..2_000).step_by(10) {
            // A quarter of the time is within the requirement.
            take(&mut alarm, f64::from(at_s), if at_s % 40 == 0 { 50.0 } else { -1.0 }, false);
            assert_eq!(alarm.is_escalated(), at_s >= 1_600, "at {at_s} s");
        }
        take(&mut alarm, 2_000.0, 500.0, false);
        assert_eq!(take(&mut alarm, 2_020.0, 500.0, false), Some(AlarmState::Kept));
        assert!(!alarm.is_escalated());
    }

    #[test]
    fn the_fourth_alarm_of_an_hour_escalates() {
        let mut alarm = Alarm::default();
        for (at_s, escalates) in [(0.0, false), (1e3, false), (2e3, false), (3e3, true), (4e3, true), (2e4, false)] {
            assert_eq!(take(&mut alarm, at_s, -1.0, false), Some(AlarmState::Raised));
            assert_eq!(alarm.is_escalated(), escalates, "at {at_s} s");
            take(&mut alarm, at_s + 100.0, 500.0, false);
            assert_eq!(take(&mut alarm, at_s + 200.0, 500.0, false), Some(AlarmState::Kept));
        }
    }
}
