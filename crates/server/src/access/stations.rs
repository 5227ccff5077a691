//! Stations: callers with a recent request that may hold authority. Authority can be offered to them.

use apex_runtime::authority::{Actor, ActorRole};
use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Time without a request after which a station is no longer listed; a page sends several requests a second.
const SILENT_AFTER: Duration = Duration::from_secs(30);
/// Maximum number of remembered stations; a further one replaces the one that has been silent longest.
const STATIONS_MAX: usize = 200;

/// The callers by name, with the instant of the last request of each.
#[derive(Default)]
pub(crate) struct Stations {
    heard: Mutex<BTreeMap<String, (ActorRole, Instant)>>,
}

impl Stations {
    /// Notes a request of `actor` at `now`. Observers do not count.
    pub(crate) fn hear(&self, actor: &Actor, now: Instant) {
        if actor.role < ActorRole::Operator {
            return;
        }
        let mut heard = self.heard.lock().unwrap_or_else(PoisonError::into_inner);
        if heard.len() >= STATIONS_MAX
            && !heard.contains_key(&actor.name)
            && let Some(oldest) = heard.iter().min_by_key(|(_, (_, at))| *at).map(|(name, _)| name.clone())
        {
            heard.remove(&oldest);
        }
        heard.insert(actor.name.clone(), (actor.role, now));
    }

    /// Returns the stations other than `actor` that are heard at `now`, by name.
    pub(crate) fn others(&self, actor: &Actor, now: Instant) -> Vec<Actor> {
        let heard = self.heard.lock().unwrap_or_else(PoisonError::into_inner);
        let is_heard = |at: Instant| now.saturating_duration_since(at) <= SILENT_AFTER;
        heard
            .iter()
            .filter(|(name, (_, at))| **name != actor.name && is_heard(*at))
            .map(|(name, (role, _))| Actor { name: name.clone(), role: *role })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn actor(name: &str, role: ActorRole) -> Actor {
        Actor { name: name.into(), role }
    }

    #[test]
    fn stations_are_other_callers_that_may_command_and_sent_a_recent_request() {
        let (stations, start) = (Stations::default(), Instant::now());
        let tower = actor("tower", ActorRole::Operator);
        stations.hear(&tower, start);
        stations.hear(&actor("van", ActorRole::PilotInCommand), start + Duration::from_secs(20));
        stations.hear(&actor("guest", ActorRole::Observer), start);
        let names = |by: &Actor, after_s: u64| -> Vec<String> {
            let listed = stations.others(by, start + Duration::from_secs(after_s));
            listed.into_iter().map(|one| one.name).collect()
        };
        assert_eq!(names(&tower, 20), ["van"]);
        assert_eq!(names(&actor("guest", ActorRole::Observer), 20), ["tower", "van"]);
        assert_eq!(names(&actor("pilot", ActorRole::Operator), 31), ["van"], "the tower is silent for 31 s");
        assert!(names(&tower, 51).is_empty());
    }

    #[test]
    fn the_station_that_was_silent_longest_gives_way() {
        let (stations, start) = (Stations::default(), Instant::now());
        for number in 0..=STATIONS_MAX {
            let name = format!("s{number:03}");
            stations.hear(&actor(&name, ActorRole::Operator), start + Duration::from_millis(number as u64));
        }
        let listed = stations.others(&actor("x", ActorRole::Operator), start + Duration::from_secs(1));
        assert_eq!(listed.len(), STATIONS_MAX);
        assert_eq!(listed.first().map(|one| one.name.as_str()), Some("s001"));
    }
}
