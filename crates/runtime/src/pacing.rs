//! Pacing: lets mission time pass at a multiple of wall time, so that people can watch.
//!
//! Only the moment at which a step is executed depends on the pace, never what is decided: without inputs from
//! outside a paced run and a fast run write the same record.

use apex_model::time::{NANOSECONDS_PER_SECOND, Time};
use std::time::{Duration, Instant};

/// Longest single sleep: keeps sums of wall time far from overflow.
const SLEEP_MAX: Duration = Duration::from_secs(3600);

/// Relates mission time to the wall clock.
#[derive(Debug)]
pub struct Pacer {
    pace: Option<f64>,
    anchor_wall: Instant,
    anchor_mission: Time,
}

/// How long to sleep before an instant of mission time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wait {
    /// The instant has come.
    Over,
    /// At most so long.
    For(Duration),
    /// Mission time stands still until the pace changes.
    Paused,
}

impl Pacer {
    /// Mission time is `now`; `pace` seconds of it pass in one second; none is as fast as possible, 0 is a pause.
    ///
    /// # Errors
    /// A sentence for a pace that is negative or no number.
    pub fn new(pace: Option<f64>, now: Time) -> Result<Pacer, String> {
        let mut pacer = Pacer { pace: None, anchor_wall: Instant::now(), anchor_mission: now };
        pacer.set(pace, now)?;
        Ok(pacer)
    }

    /// Changes the pace at mission time `now`.
    ///
    /// # Errors
    /// A sentence for a pace that is negative or no number; the old pace stays.
    pub fn set(&mut self, pace: Option<f64>, now: Time) -> Result<(), String> {
        if let Some(pace) = pace.filter(|pace| !(0.0..=1e9).contains(pace)) {
            return Err(format!(
                "A pace of {pace} makes no sense: give mission seconds per second, 1 for real time, 0 for a pause."
            ));
        }
        *self = Pacer { pace, anchor_wall: Instant::now(), anchor_mission: now };
        Ok(())
    }

    /// True when steps wait for the wall clock.
    pub fn is_paced(&self) -> bool {
        self.pace.is_some()
    }

    /// How long to wait before `instant`.
    pub fn wait(&self, instant: Time) -> Wait {
        let Some(pace) = self.pace else { return Wait::Over };
        if instant <= self.anchor_mission {
            return Wait::Over;
        }
        if pace <= 0.0 {
            return Wait::Paused;
        }
        let wall_s = (instant - self.anchor_mission).seconds() / pace - self.anchor_wall.elapsed().as_secs_f64();
        if wall_s <= 0.0 {
            Wait::Over
        } else {
            Wait::For(Duration::try_from_secs_f64(wall_s).unwrap_or(SLEEP_MAX).min(SLEEP_MAX))
        }
    }

    /// How long ago, in wall time, `instant` was; nothing where it is to come, or nobody waits for a clock.
    pub fn lateness(&self, instant: Time) -> Duration {
        let Some(pace) = self.pace.filter(|pace| *pace > 0.0) else { return Duration::ZERO };
        let due_s = (instant - self.anchor_mission).seconds() / pace;
        Duration::try_from_secs_f64(self.anchor_wall.elapsed().as_secs_f64() - due_s.max(0.0)).unwrap_or(Duration::ZERO)
    }

    /// Mission time by the wall clock, within `from ..= to`.
    pub fn now(&self, from: Time, to: Time) -> Time {
        let Some(pace) = self.pace else { return to };
        let passed_s = self.anchor_wall.elapsed().as_secs_f64() * pace;
        let passed = apex_model::time::Duration((passed_s * NANOSECONDS_PER_SECOND as f64) as i64);
        (self.anchor_mission + passed).clamp(from, to.max(from))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ten_times_real_time_waits_a_tenth() {
        let pacer = Pacer::new(Some(10.0), Time::ZERO).unwrap();
        let Wait::For(wait) = pacer.wait(Time::from_seconds(20.0)) else { panic!("must wait") };
        assert!(wait.as_secs_f64() > 1.9 && wait.as_secs_f64() <= 2.0, "{wait:?}");
        assert_eq!(pacer.wait(Time::ZERO), Wait::Over);
    }

    #[test]
    fn no_pace_never_waits_and_zero_waits_for_ever() {
        let later = Time::from_seconds(1e6);
        assert_eq!(Pacer::new(None, Time::ZERO).unwrap().wait(later), Wait::Over);
        assert_eq!(Pacer::new(Some(0.0), Time::ZERO).unwrap().wait(later), Wait::Paused);
        assert!(Pacer::new(Some(-1.0), Time::ZERO).unwrap_err().contains("-1"));
        assert!(Pacer::new(Some(f64::NAN), Time::ZERO).is_err());
    }
}
