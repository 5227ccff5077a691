//! Token buckets, with time passed in by the caller.

use std::time::Duration;

/// An empty bucket reopens when it holds what arrives in this time: inputs then pass in groups instead of one by one.
const GROUP: Duration = Duration::from_millis(5);
/// Capacity of a bucket, as the time in which that number of items arrives.
const BURST_S: f64 = 0.1;

/// Lets a number of items per second pass, and a short burst.
#[derive(Clone, Debug)]
pub struct RateLimit {
    per_second: f64,
    burst: f64,
    tokens: f64,
    at: Duration,
    /// True if the bucket ran empty; it is closed until it holds a group.
    closed: bool,
}

impl RateLimit {
    /// Returns a full bucket for `per_second` items; its burst is a tenth of a second's items.
    pub fn new(per_second: u32) -> RateLimit {
        RateLimit::with_burst(f64::from(per_second), (f64::from(per_second) * BURST_S).max(1.0))
    }

    /// Returns a full bucket that holds `burst` items.
    pub fn with_burst(per_second: f64, burst: f64) -> RateLimit {
        RateLimit { per_second, burst, tokens: burst, at: Duration::ZERO, closed: false }
    }

    fn group(&self) -> f64 {
        (self.per_second * GROUP.as_secs_f64()).clamp(1.0, self.burst)
    }

    /// Returns the number of items that may pass at `now`, a time since any fixed instant.
    pub fn available(&mut self, now: Duration) -> usize {
        let passed_s = now.saturating_sub(self.at).as_secs_f64();
        self.at = self.at.max(now);
        self.tokens = (self.tokens + passed_s * self.per_second).min(self.burst);
        if self.closed && self.tokens >= self.group() {
            self.closed = false;
        }
        if self.closed { 0 } else { self.tokens as usize }
    }

    /// Removes `count` items from the bucket.
    pub fn spend(&mut self, count: usize) {
        self.tokens = (self.tokens - count as f64).max(0.0);
        self.closed = self.closed || self.tokens < 1.0;
    }

    /// Returns true and removes one item if the bucket permits it at `now`.
    pub fn admits(&mut self, now: Duration) -> bool {
        let admitted = self.available(now) > 0;
        if admitted {
            self.spend(1);
        }
        admitted
    }

    /// Returns the time from the last refill until items may pass; zero if they may now.
    pub fn ready_in(&self) -> Duration {
        if !self.closed && self.tokens >= 1.0 {
            return Duration::ZERO;
        }
        let missing = (self.group() - self.tokens).max(0.0);
        Duration::try_from_secs_f64(missing / self.per_second).unwrap_or(GROUP)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flood_passes_at_the_rate_and_a_pause_allows_a_burst() {
        let mut limit = RateLimit::new(2_000);
        let mut passed = 0;
        for millisecond in 0..1_000 {
            let count = limit.available(Duration::from_millis(millisecond)).min(150);
            limit.spend(count);
            passed += count;
        }
        assert!((2_150..=2_210).contains(&passed), "200 at once, then 2 a millisecond: {passed}");
        assert_eq!(limit.available(Duration::from_secs(60)), 200, "a long pause saves no more than a burst");
    }

    #[test]
    fn an_empty_bucket_opens_for_a_group() {
        let mut limit = RateLimit::new(2_000);
        limit.spend(limit.clone().available(Duration::ZERO));
        assert_eq!(limit.available(Duration::from_millis(4)), 0, "a group has 10 items");
        assert!(limit.ready_in() > Duration::ZERO);
        let ready = Duration::from_millis(4) + limit.ready_in() + Duration::from_micros(1);
        assert_eq!(limit.available(ready), 10);
        assert_eq!(limit.ready_in(), Duration::ZERO);
        let mut slow = RateLimit::with_burst(5.0, 20.0);
        assert_eq!((0..30).filter(|_| slow.admits(Duration::ZERO)).count(), 20);
        assert!(!slow.admits(Duration::from_millis(100)) && slow.admits(Duration::from_millis(201)));
    }
}
