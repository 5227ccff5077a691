//! Pacing: lets mission time pass at a multiple of wall time, so that operators can watch.
//!
//! The pace decides only when a step is executed, never its result: without inputs from outside, and while no solver is late, a paced run
//! and a fast run write the same record. A run that does not wait for planners and is faster than the wall clock also has a sample of
//! `(mission-pace)`.

use apex_model::time::{NANOSECONDS_PER_SECOND, Time};
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Longest single sleep: keeps sums of wall time far from overflow.
const SLEEP_MAX: Duration = Duration::from_secs(3600);

/// A clock by which a pace is kept.
pub trait Clock: fmt::Debug + Send + Sync {
    /// Returns the time since a fixed instant that the clock has chosen.
    fn elapsed(&self) -> Duration;
    /// Blocks the thread for `span`.
    fn sleep(&self, span: Duration);
}

/// Wall time.
#[derive(Debug)]
pub struct WallClock(Instant);

impl WallClock {
    /// Returns a clock that counts from now on.
    pub fn new() -> WallClock {
        WallClock(Instant::now())
    }
}

impl Default for WallClock {
    fn default() -> WallClock {
        WallClock::new()
    }
}

impl Clock for WallClock {
    fn elapsed(&self) -> Duration {
        self.0.elapsed()
    }
    fn sleep(&self, span: Duration) {
        std::thread::sleep(span);
    }
}

/// A clock that advances only by sleeping, which takes no time: for tests of paced flights.
#[derive(Debug, Default)]
pub struct ManualClock(Mutex<Duration>);

impl Clock for ManualClock {
    fn elapsed(&self) -> Duration {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
    fn sleep(&self, span: Duration) {
        let mut elapsed = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        *elapsed = elapsed.saturating_add(span);
    }
}

/// Relates mission time to the wall clock.
#[derive(Debug)]
pub struct Pacer {
    pace: Option<f64>,
    clock: Arc<dyn Clock>,
    anchor_wall: Duration,
    anchor_mission: Time,
}

/// Wait before an instant of mission time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wait {
    /// The instant has arrived.
    Over,
    /// At most this duration.
    For(Duration),
    /// Mission time stands still until the pace changes.
    Paused,
}

impl Wait {
    /// Waits no longer than `span`.
    pub fn at_most(self, span: Duration) -> Wait {
        match self {
            Wait::Over => Wait::Over,
            Wait::For(own) => Wait::For(own.min(span)),
            Wait::Paused => Wait::For(span),
        }
    }
}

impl Pacer {
    /// Returns a pacer at mission time `now`. `pace` is the mission time in seconds that passes in one second of wall time: `None` as
    /// fast as possible, 0 a pause.
    ///
    /// # Errors
    /// A message for a pace that is negative or not a number.
    pub fn new(pace: Option<f64>, now: Time, clock: Arc<dyn Clock>) -> Result<Pacer, String> {
        let mut pacer = Pacer { pace: None, anchor_wall: clock.elapsed(), clock, anchor_mission: now };
        pacer.set(pace, now)?;
        Ok(pacer)
    }

    /// Changes the pace at mission time `now`.
    ///
    /// # Errors
    /// A message for a pace that is negative or not a number; the old pace stays.
    pub fn set(&mut self, pace: Option<f64>, now: Time) -> Result<(), String> {
        if let Some(pace) = pace.filter(|pace| !(0.0..=1e9).contains(pace)) {
            return Err(format!(
                "a pace of {pace} is invalid: give mission seconds per second, 1 for real time, 0 for a pause"
            ));
        }
        (self.pace, self.anchor_wall, self.anchor_mission) = (pace, self.clock.elapsed(), now);
        Ok(())
    }

    /// Records that mission time was `now` until this moment of the clock.
    pub fn hold(&mut self, now: Time) {
        (self.anchor_wall, self.anchor_mission) = (self.clock.elapsed(), now);
    }

    fn elapsed_s(&self) -> f64 {
        self.clock.elapsed().saturating_sub(self.anchor_wall).as_secs_f64()
    }

    /// Waits by its clock.
    pub fn sleep(&self, span: Duration) {
        self.clock.sleep(span);
    }

    /// Returns the pace in mission seconds per second of wall time; `None` as fast as possible.
    pub fn pace(&self) -> Option<f64> {
        self.pace
    }

    /// Returns true when steps wait for the wall clock.
    pub fn is_paced(&self) -> bool {
        self.pace.is_some()
    }

    /// Returns the wait before `instant`.
    pub fn wait(&self, instant: Time) -> Wait {
        let Some(pace) = self.pace else { return Wait::Over };
        if instant <= self.anchor_mission {
            return Wait::Over;
        }
        if pace <= 0.0 {
            return Wait::Paused;
        }
        let wall_s = (instant - self.anchor_mission).seconds() / pace - self.elapsed_s();
        if wall_s <= 0.0 {
            Wait::Over
        } else {
            Wait::For(Duration::try_from_secs_f64(wall_s).unwrap_or(SLEEP_MAX).min(SLEEP_MAX))
        }
    }

    /// Returns the wall time that has passed since `instant`; zero if it is in the future, or without a clock.
    pub fn lateness(&self, instant: Time) -> Duration {
        let Some(pace) = self.pace.filter(|pace| *pace > 0.0) else { return Duration::ZERO };
        let due_s = (instant - self.anchor_mission).seconds() / pace;
        Duration::try_from_secs_f64(self.elapsed_s() - due_s.max(0.0)).unwrap_or(Duration::ZERO)
    }

    /// Returns the mission time by the wall clock, within `from ..= to`.
    pub fn now(&self, from: Time, to: Time) -> Time {
        let Some(pace) = self.pace else { return to };
        let passed_s = self.elapsed_s() * pace;
        let passed = apex_model::time::Duration((passed_s * NANOSECONDS_PER_SECOND as f64) as i64);
        (self.anchor_mission + passed).clamp(from, to.max(from))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wall() -> Arc<dyn Clock> {
        Arc::new(WallClock::new())
    }

    #[test]
    fn ten_times_real_time_waits_a_tenth() {
        let pacer = Pacer::new(Some(10.0), Time::ZERO, wall()).unwrap();
        let Wait::For(wait) = pacer.wait(Time::from_seconds(20.0)) else { panic!("must wait") };
        assert!(wait.as_secs_f64() > 1.9 && wait.as_secs_f64() <= 2.0, "{wait:?}");
        assert_eq!(pacer.wait(Time::ZERO), Wait::Over);
    }

    #[test]
    fn no_pace_never_waits_and_zero_waits_indefinitely() {
        let later = Time::from_seconds(1e6);
        assert_eq!(Pacer::new(None, Time::ZERO, wall()).unwrap().wait(later), Wait::Over);
        assert_eq!(Pacer::new(Some(0.0), Time::ZERO, wall()).unwrap().wait(later), Wait::Paused);
        assert!(Pacer::new(Some(-1.0), Time::ZERO, wall()).unwrap_err().contains("-1"));
        assert!(Pacer::new(Some(f64::NAN), Time::ZERO, wall()).is_err());
    }
}
