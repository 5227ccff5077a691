//! Messages of library `contingencies` as lines of the report: what failed, and what the aircraft does.

use apex_model::value::Value;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// The landing by a contingency: each of its parts reports the requirements that it has to break, but the decision is one.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct ContingencyLanding {
    /// Names of requirements that are broken on purpose; `None` before such a landing.
    broken: Option<BTreeSet<String>>,
}

impl ContingencyLanding {
    /// Begins a landing if a message announces one.
    pub(super) fn begin_if(&mut self, lands: bool) {
        if lands {
            self.broken = Some(BTreeSet::new());
        }
    }

    /// Returns the line of the report for a requirement that no way keeps; `None` if the landing has reported it.
    pub(super) fn broken(&mut self, name: String, why: &str) -> Option<String> {
        let Some(known) = &mut self.broken else {
            return Some(format!("a requirement has to be broken: {name}, because {why}"));
        };
        let line = format!("this landing breaks {name} on purpose, because {why}");
        known.insert(name).then_some(line)
    }
}

/// Returns the word of reports for a reading.
fn position_of(reading: &str) -> &str {
    if reading == "location" { "position" } else { reading }
}

/// Returns the line for a message; `None` for another message.
pub(super) fn line(head: &str, items: &[Value]) -> Option<String> {
    let item = |index: usize| items.get(index).filter(|value| value.is_true()).map(Value::to_string);
    let subject = item(0)?;
    Some(match head {
        "engine-out" => match item(1) {
            Some(place) => format!("the engine has stopped: gliding to {place}"),
            None => "the engine has stopped: no landing place is in reach, landing here".to_string(),
        },
        "leak-found" => "more energy is lost than the engine uses".to_string(),
        "landing-because" if subject == "storm" => {
            let place = item(1).map_or_else(String::new, |place| format!(" at {place}"));
            format!("a storm has stood over the landing place for too long: landing early{place}")
        }
        "landing-because" if subject == "engine" => {
            let place = item(1).map_or_else(String::new, |place| format!(" at {place}"));
            format!("the engine runs again: landing early{place}")
        }
        "landing-because" => match item(1) {
            Some(place) => format!("landing early at {place}: {subject}"),
            None => format!("landing early: {subject}"),
        },
        "landing-after-failed-flight" => format!("the flight to {subject} failed or had no answer: landing there"),
        "reading-frozen" | "reading-silent" if subject != "altitude" => {
            let what = if head == "reading-frozen" { "is frozen" } else { "is missing" };
            let response = if subject == "location" { "waiting for it" } else { "landing" };
            format!("the reading of the {} {what}: {response}", position_of(&subject))
        }
        "reading-regained" => format!("the reading of the {} has returned", position_of(&subject)),
        "reading-frozen" => format!("the reading of the {subject} is frozen: flying higher, unless the aircraft lands"),
        "navigation-degraded" => "navigation is degraded: flying higher".to_string(),
        "navigation-lost" => "navigation is lost".to_string(),
        "navigation-regained" => "navigation has returned".to_string(),
        "icing-met" => "ice forms: changing altitude".to_string(),
        "icing-expected" => "ice was met near here: staying off its altitude".to_string(),
        "icing-left" => "the aircraft has left the ice".to_string(),
        "rough-air" => "rough air: flying slower".to_string(),
        "smooth-air" => "the air is smooth again".to_string(),
        "storm-ahead" => "a storm is ahead: flying around it".to_string(),
        "storm-passed" => "the aircraft has passed the storm".to_string(),
        "camera-hot" => format!("{subject} gets hot: switching it off"),
        "camera-cool" => format!("{subject} is cool again"),
        "sun-near" => format!("the sun is near the line of sight of {subject}: the camera is at rest"),
        "sun-clear" => format!("the sun is no longer near the line of sight of {subject}"),
        "lease-expired" => format!("the lease of {subject} has expired: waiting"),
        "lease-regained" => format!("the lease of {subject} is renewed"),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_glide_names_its_place_or_that_there_is_none() {
        let said = |items: &[Value]| line("engine-out", items).unwrap();
        let vehicle = Value::symbol("uav-1");
        assert_eq!(said(&[vehicle.clone(), Value::symbol("home")]), "the engine has stopped: gliding to home");
        assert!(said(&[vehicle.clone(), Value::nil()]).contains("no landing place is in reach"));
        assert_eq!(line("ready", &[vehicle]), None);
    }
}
