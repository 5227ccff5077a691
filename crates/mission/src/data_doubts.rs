//! Doubts about a mission's data files: properties and scripted messages that have no effect and resemble those that have one.

use crate::Mission;
use crate::features;
use crate::situation::{MissionUpdate, MissionUpdates};
use crate::sources::DataFile;
use crate::targets::LOOK_PROPERTIES;
use apex_model::event::EventKind;
use apex_model::symbol::Symbol;
use apex_model::time::Time;
use apex_model::value::Value;
use std::collections::{BTreeMap, BTreeSet};

/// Properties of targets that have an effect, except those of looks (docs/reference/mission-data.md).
const TARGET_PROPERTIES: &[&str] = &[
    "name",
    "kind",
    "elevation_m",
    "height_m",
    "priority",
    "announced",
    "acres",
    "coverage",
    "perimeter_width_m",
    "interior_weight",
    "water",
    "after",
    "early_factor",
    "looks",
    "camera",
    "overlap",
    "sidelap",
    "pictures",
    "importance",
    "rate_per_h",
    "rates_per_h",
    "cost",
    "cost_growth_per_h",
    "cost_delay_s",
    "cost_points",
    "dwell_s",
    "response_s",
    "initial_age_s",
];

/// Properties of airspace zones.
const ZONE_PROPERTIES: &[&str] = &["id", "name", "kind", "altitude_m_min", "altitude_m_max", "active_h"];

/// Properties of airfields.
const FIELD_PROPERTIES: &[&str] = &["id", "name", "elevation_m", "runway_m"];

/// Parts of property names that state units.
const UNITS: &[&str] = &["m", "ft", "km", "nm", "h", "hours", "min", "s", "deg", "rad", "mps", "kt", "msl"];

/// Messages that planners understand, see [`MissionUpdate::read`].
const MESSAGES: &[&str] = &[
    "new-target",
    "target-gone",
    "new-value",
    "new-perimeter",
    "new-likelihood",
    "new-forecast",
    "planned-by-people",
    "plan-imposed",
];

/// Least length of a word that is compared with others letter by letter.
const COMPARED_LENGTH_MIN: usize = 5;

impl Mission {
    /// Returns doubts about properties of targets, zones and airfields that have no effect and resemble one that has, and about scripted
    /// messages that no planner understands as written, or that come after the end.
    pub(crate) fn data_doubts(&self) -> Vec<String> {
        let settings = &self.settings;
        let looks_too: Vec<&str> = TARGET_PROPERTIES.iter().chain(LOOK_PROPERTIES).copied().collect();
        let files = [
            (&settings.targets, looks_too.as_slice()),
            (&settings.airspace, ZONE_PROPERTIES),
            (&settings.airfields, FIELD_PROPERTIES),
        ];
        let mut found: Vec<String> = Vec::new();
        for (name, known) in files.into_iter().filter_map(|(name, known)| Some((name.as_deref()?, known))) {
            found.extend(self.property_doubts(name, known));
        }
        found.extend(self.scenario_doubts());
        found
    }

    /// Returns a doubt for each property in file `name` that is not `known` and resembles one that is.
    fn property_doubts(&self, name: &str, known: &[&str]) -> Vec<String> {
        let Some((_, bytes)) = self.data.iter().find(|(file, _)| file == name) else { return Vec::new() };
        let file = DataFile { place: name.to_string(), bytes: bytes.clone() };
        let Ok(features) = features::read(&file) else { return Vec::new() };
        // The first feature with the property, and the number of features.
        let mut unknown: BTreeMap<&str, (&str, usize)> = BTreeMap::new();
        for feature in &features {
            for property in feature.properties().filter(|property| !known.contains(property)) {
                unknown.entry(property).or_insert((&feature.id, 0)).1 += 1;
            }
        }
        let sentence = |(property, (first, count)): (&str, (&str, usize))| {
            let meant = resembled(property, known)?;
            let others = if count > 1 { format!(" and {} more", count - 1) } else { String::new() };
            Some(format!("{name}: the property `{property}` of {first}{others} has no effect: did you mean `{meant}`?"))
        };
        unknown.into_iter().filter_map(sentence).collect()
    }

    /// Returns a doubt for each message of the scenario that changes nothing, and one for all inputs after the end.
    fn scenario_doubts(&self) -> Vec<String> {
        let file = self.settings.scenario.as_deref().unwrap_or_default();
        let (duration, end) = (self.settings.duration, Time::ZERO + self.settings.duration);
        let mut found: Vec<String> = Vec::new();
        // A message that is repeated is reported once.
        let mut reported: BTreeSet<String> = BTreeSet::new();
        for input in self.scenario.iter().filter(|input| input.at <= end) {
            let EventKind::Occurrence(Value::List(form)) = &input.kind else { continue };
            let [Value::Symbol(head), items @ ..] = &**form else { continue };
            let Some(doubt) = self.message_doubt(head, items) else { continue };
            let subject = items.first().map_or_else(String::new, |item| format!(" {item}"));
            let message = format!("({head}{subject}{})", if items.len() > 1 { " .." } else { "" });
            if reported.insert(message.clone()) {
                found.push(format!("{file}: `{message}` at {}: {doubt}", input.at));
            }
        }
        let late = || self.scenario.iter().filter(|input| input.at > end);
        let first = late().map(|input| input.at).min();
        found.extend(first.map(|at| match late().count() {
            1 => format!("{file}: an input at {at} comes after the end of the mission, at {duration}"),
            count => format!(
                "{file}: {count} inputs come after the end of the mission, at {duration}; the first of them at {at}"
            ),
        }));
        found
    }

    /// Returns the reason for which a message changes nothing, if it is known: the reason that the flight would report, or the resemblance
    /// to a message that planners understand.
    fn message_doubt(&self, head: &Symbol, items: &[Value]) -> Option<String> {
        match MissionUpdate::read(head.folded(), items) {
            Some(MissionUpdate::Invalid(why)) => Some(why),
            Some(update) => {
                let why = MissionUpdates::without_subject(&update, self)?;
                let near =
                    items.first().and_then(Value::as_symbol).and_then(|name| self.resembled_target(name.folded()));
                Some(near.map_or_else(|| why.clone(), |near| format!("{why}; did you mean `{near}`?")))
            }
            None => resembled_message(head).map(|meant| format!("did you mean `{meant}`?")),
        }
    }

    /// Returns the target whose id differs least from `name`, by two letters at most.
    fn resembled_target(&self, name: &str) -> Option<&str> {
        let ids = self.targets.iter().map(|target| target.id.as_str());
        let far = |id: &str| strsim::damerau_levenshtein(id, name);
        ids.min_by_key(|id| far(id)).filter(|id| far(id) <= 2)
    }
}

/// Returns the known property that a name resembles: the same in another case, with another unit or without one, with its parts in another
/// order, or with one letter different.
fn resembled<'k>(property: &str, known: &[&'k str]) -> Option<&'k str> {
    let parts = |name: &str| {
        let name = name.to_lowercase();
        let mut parts: Vec<String> =
            name.split(['_', '-', ' ']).filter(|part| !UNITS.contains(part)).map(str::to_string).collect();
        parts.sort();
        parts
    };
    let own = parts(property);
    let same = known.iter().find(|name| parts(name) == own && !own.is_empty());
    same.or_else(|| known.iter().find(|name| differs_by_a_letter(&property.to_lowercase(), name))).copied()
}

fn resembled_message(head: &Symbol) -> Option<&'static str> {
    MESSAGES.iter().find(|message| differs_by_a_letter(head.folded(), message)).copied()
}

fn differs_by_a_letter(word: &str, known: &str) -> bool {
    word.len().min(known.len()) >= COMPARED_LENGTH_MIN && strsim::damerau_levenshtein(word, known) == 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_other_case_unit_order_or_letter_resemble_a_property() {
        for (property, known, meant) in [
            ("Value", "value", true),
            ("resolution", "resolution_m", true),
            ("elevation_ft", "elevation_m", true),
            ("windows_H", "windows_h", true),
            ("altitude_max_m", "altitude_m_max", true),
            ("altitude_ft_max", "altitude_m_max", true),
            ("acers", "acres", true),
            ("values", "value", true),
            ("active_from_s", "active_h", false),
            ("m", "value", false),
            ("cots", "cost", false),
            ("notes", "name", false),
        ] {
            assert_eq!(resembled(property, &[known]).is_some(), meant, "{property} and {known}");
        }
        assert_eq!(resembled_message(&Symbol::new("target-gon")), Some("target-gone"));
        assert_eq!(resembled_message(&Symbol::new("target-gone")), None);
        assert_eq!(resembled_message(&Symbol::new("start")), None);
    }

    /// Each name is that of a message that is read, and no message of the page is missing.
    #[test]
    fn the_messages_are_those_that_are_read() {
        let page = include_str!("../../../docs/reference/mission-data.md");
        let rows = page.lines().filter_map(|line| line.strip_prefix("| `("));
        let documented: BTreeSet<&str> = rows.filter_map(|row| row.split([' ', ')']).next()).collect();
        for message in MESSAGES {
            assert!(MissionUpdate::read(message, &[Value::symbol("a")]).is_some(), "{message}");
            assert!(documented.contains(message), "{message} is not documented");
        }
        let is_read = |word: &&&str| MissionUpdate::read(word, &[Value::symbol("a")]).is_some();
        assert_eq!(documented.iter().filter(is_read).count(), MESSAGES.len());
    }

    /// The tables of the documentation name each property.
    #[test]
    fn the_properties_are_those_of_the_documentation() {
        let page = include_str!("../../../docs/reference/mission-data.md");
        let of = |heading: &str| -> Vec<&str> {
            let section = page.split("\n## ").find(|section| section.starts_with(heading)).expect(heading);
            let rows = section.lines().filter_map(|line| line.strip_prefix("| `"));
            let names = rows.filter(|row| !row.starts_with('(')).filter_map(|row| row.split('`').next());
            let kinds = ["fire", "inspection", "structure", "target", "base"];
            names.filter(|name| !name.starts_with(':') && !kinds.contains(name)).collect()
        };
        let targets = of("Targets");
        let known: Vec<&str> = TARGET_PROPERTIES.iter().chain(LOOK_PROPERTIES).copied().collect();
        for name in &targets {
            assert!(known.contains(name), "{name} is documented");
        }
        for name in known.iter().filter(|name| !["id", "name", "kind"].contains(name)) {
            assert!(targets.contains(name), "{name} is not documented");
        }
        for name in of("Airspace") {
            assert!(ZONE_PROPERTIES.contains(&name), "{name}");
        }
    }
}
