//! News in flight: what is said of targets and of the weather after the start, and the mission as it is believed since.
//!
//! Events are read off the record's inputs, so planning again in replay believes the same (docs/reference/mission-data.md, "News in flight").

use super::{Mission, TargetKind};
use apex_model::problem::{CostFunction, EventRate};
use apex_model::quantity::Dimension;
use apex_model::value::Value;
use apex_solvers::planners::human::Human;
use std::collections::{BTreeMap, BTreeSet};

const SECONDS_PER_HOUR: f64 = 3600.0;
/// What a target may be worth and how often something may happen there: as in the mission's own files.
const VALUE_MAX: f64 = 1e9;
const RATE_PER_H_MAX: f64 = 1e6;

/// What has been said so far; the last word on a target counts.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct News {
    /// Targets announced during the flight, by `(new-target ID)`.
    announced: BTreeSet<String>,
    /// Targets that need no observation any more, by `(target-gone ID)`.
    gone: BTreeSet<String>,
    /// Worth of fires and importance of structures, by `(new-value ID NUMBER)`.
    values: BTreeMap<String, f64>,
    /// Events per hour, by `(new-likelihood ID NUMBER)`.
    rates_per_h: BTreeMap<String, f64>,
    /// Files of forecasts in the order in which they were said last, by `(new-forecast FILE)`; the last one that the mission has
    /// is believed.
    forecasts: Vec<String>,
    /// What a person wants, by `(planned-by-people ([repeat] TARGET ..))`.
    visits: Option<Human>,
}

impl News {
    /// Takes an event. Nothing when it is no news, else a line for the report.
    pub fn take(&mut self, head: &str, items: &[Value]) -> Option<String> {
        let subject = items.first().map(name)?;
        let amount = |most: f64| {
            let number = items.get(1).and_then(Value::as_number).filter(|(_, dimension)| *dimension == Dimension::NONE);
            number.map(|(number, _)| number).filter(|number| (0.0..=most).contains(number))
        };
        let unread = |most: f64| {
            Some(format!("({head} {subject} ..) is without a number from 0 to {most}, and changes nothing"))
        };
        match head {
            "new-target" => {
                self.gone.remove(&subject);
                let note = format!("new target: {subject}");
                self.announced.insert(subject);
                Some(note)
            }
            "target-gone" => {
                let note = format!("no target any more: {subject}");
                self.gone.insert(subject);
                Some(note)
            }
            "new-value" => {
                let Some(value) = amount(VALUE_MAX) else { return unread(VALUE_MAX) };
                let note = format!("{subject} is worth {value} from now on");
                self.values.insert(subject, value);
                Some(note)
            }
            "new-likelihood" => {
                let Some(rate_per_h) = amount(RATE_PER_H_MAX) else { return unread(RATE_PER_H_MAX) };
                let note = format!("{subject}: {rate_per_h} events an hour from now on");
                self.rates_per_h.insert(subject, rate_per_h);
                Some(note)
            }
            "new-forecast" => {
                let note = format!("new forecast: {subject}");
                self.forecasts.retain(|known| *known != subject);
                self.forecasts.push(subject);
                Some(note)
            }
            "planned-by-people" => Some(self.planned_by_people(items)),
            _ => None,
        }
    }

    /// An answer without visits is one too: it takes the place of an older one, which is not flown again.
    fn planned_by_people(&mut self, items: &[Value]) -> String {
        let said = items.first().and_then(Value::as_list).unwrap_or_default();
        let mut visits: Vec<String> = said.iter().map(name).collect();
        let repeat = visits.first().is_some_and(|first| first == "repeat");
        visits.drain(..usize::from(repeat));
        if visits.is_empty() {
            self.visits = None;
            let said: Vec<String> = items.iter().map(Value::to_string).collect();
            return format!("planned by people: {}, which names no visits", said.join(" "));
        }
        let again = if repeat { ", again and again" } else { "" };
        let note = format!("planned by people: {}{again}", visits.join(", "));
        self.visits = Some(Human { visits, repeat });
        note
    }

    /// True when the target has been announced.
    pub fn is_announced(&self, target: &str) -> bool {
        self.announced.contains(target)
    }

    /// The visits that a person wants.
    pub fn visits(&self) -> Option<&Human> {
        self.visits.as_ref()
    }

    /// What of it names nothing of the mission, or says what its target cannot have, in words.
    pub fn unknown(&self, mission: &Mission) -> Vec<String> {
        let find = |id: &String| mission.targets.iter().find(|target| target.id == *id);
        let named = self.announced.iter().chain(&self.gone).chain(self.values.keys()).chain(self.rates_per_h.keys());
        let strange: BTreeSet<&String> = named.filter(|id| find(id).is_none()).collect();
        let targets = strange.into_iter().map(|id| format!("{id} is no target of this mission"));
        let calm = |id: &&String| find(id).is_some_and(|target| !matches!(target.kind, TargetKind::Site(_)));
        let likely = self.rates_per_h.keys().filter(calm);
        let likely = likely.map(|id| format!("{id} is no structure, and has no likelihood"));
        let file = |name: &&String| !mission.forecasts.iter().any(|(known, _)| known == *name);
        let forecasts = self.forecasts.iter().filter(file).map(|name| {
            let known: Vec<&str> = mission.forecasts.iter().map(|(known, _)| known.as_str()).collect();
            format!("{name} is none of the mission's forecasts, {}", known.join(", "))
        });
        targets.chain(likely).chain(forecasts).collect()
    }

    /// The mission as it is believed after the news: with what is known of its targets and winds now.
    pub fn believed(&self, mission: &Mission) -> Mission {
        let mut believed = self.valued(mission);
        believed.targets.retain(|target| {
            let hidden = target.announced_late && !self.is_announced(&target.id);
            !hidden && !self.gone.contains(&target.id)
        });
        believed
    }

    /// The mission with all of its targets, worth what has been said last, and the forecast that is believed.
    pub fn valued(&self, mission: &Mission) -> Mission {
        let mut believed = mission.clone();
        for target in &mut believed.targets {
            let (value, rate_per_h) = (self.values.get(&target.id), self.rates_per_h.get(&target.id));
            match &mut target.kind {
                TargetKind::Fire(fire) => fire.value = value.copied().unwrap_or(fire.value),
                TargetKind::Site(site) => {
                    if let Some(rate_per_h) = rate_per_h {
                        site.rate = EventRate::constant(rate_per_h / SECONDS_PER_HOUR);
                    }
                    let importance = importance(&site.cost, site.importance);
                    if let Some(value) = value.filter(|_| importance > 0.0) {
                        site.cost = scaled(&site.cost, value / importance);
                        site.importance = *value;
                    }
                }
                TargetKind::Plain | TargetKind::Base => {}
            }
        }
        let known = |name: &String| mission.forecasts.iter().find(|(known, _)| known == name);
        if let Some((_, forecast)) = self.forecasts.iter().rev().find_map(known) {
            believed.forecast = forecast.clone();
        }
        believed
    }
}

/// A name as events have it: a symbol or a text.
fn name(value: &Value) -> String {
    match value {
        Value::Text(text) => text.to_string(),
        Value::Symbol(symbol) => symbol.folded().to_string(),
        other => other.to_string(),
    }
}

/// What `importance` stands for: of a table, the cost of an event that is never found.
fn importance(cost: &CostFunction, of_families: f64) -> f64 {
    match cost {
        CostFunction::Table { points } => points.last().map_or(0.0, |(_, cost)| *cost),
        CostFunction::Delayed { cost, .. } => importance(cost, of_families),
        _ => of_families,
    }
}

/// The same cost, `factor` times as high.
fn scaled(cost: &CostFunction, factor: f64) -> CostFunction {
    let mut cost = cost.clone();
    match &mut cost {
        CostFunction::Linear { cost_per_s } => *cost_per_s *= factor,
        CostFunction::Saturating { maximum, .. }
        | CostFunction::Step { maximum, .. }
        | CostFunction::Logistic { maximum, .. } => *maximum *= factor,
        CostFunction::Table { points } => points.iter_mut().for_each(|(_, cost)| *cost *= factor),
        CostFunction::Delayed { cost, .. } => **cost = scaled(cost, factor),
    }
    cost
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_model::problem::WindField;
    use apex_model::symbol::Symbol;

    fn said(news: &mut News, head: &str, items: &[Value]) -> String {
        news.take(head, items).unwrap_or_default()
    }

    #[test]
    fn what_is_no_news_is_left_alone() {
        let mut news = News::default();
        assert_eq!(news.take("observed", &[Value::symbol("barn")]), None);
        assert_eq!(news.take("new-target", &[]), None);
        assert_eq!(news, News::default());
    }

    #[test]
    fn a_value_that_is_none_changes_nothing_and_is_told() {
        let mut news = News::default();
        let barn = Value::Symbol(Symbol::new("barn"));
        let long = Value::Duration(apex_model::time::Duration::from_seconds(60.0));
        for bad in [Value::Real(-1.0), Value::Real(f64::NAN), Value::Real(2e9), Value::symbol("much"), long] {
            assert!(said(&mut news, "new-value", &[barn.clone(), bad]).contains("changes nothing"));
        }
        assert!(said(&mut news, "new-likelihood", &[barn]).contains("changes nothing"));
        assert_eq!(news, News::default());
    }

    #[test]
    fn a_target_that_is_announced_again_is_back() {
        let mut news = News::default();
        let barn = [Value::symbol("barn")];
        said(&mut news, "target-gone", &barn);
        assert!(news.gone.contains("barn"));
        said(&mut news, "new-target", &barn);
        assert!(news.gone.is_empty() && news.is_announced("barn"));
    }

    #[test]
    fn an_answer_that_names_no_visits_takes_the_older_one_back() {
        let barn = Value::list([Value::symbol("repeat"), Value::symbol("barn")]);
        let empty =
            [vec![Value::symbol("nobody")], vec![Value::list([])], vec![Value::list([Value::symbol("repeat")])]];
        for empty in empty {
            let mut news = News::default();
            assert_eq!(
                said(&mut news, "planned-by-people", std::slice::from_ref(&barn)),
                "planned by people: barn, again and again"
            );
            assert_eq!(news.visits(), Some(&Human { visits: vec!["barn".to_string()], repeat: true }));
            let note = said(&mut news, "planned-by-people", &empty);
            assert!(note.ends_with("which names no visits"), "{note}");
            assert_eq!(news.visits(), None, "{note}");
        }
    }

    #[test]
    fn the_last_word_that_the_mission_knows_is_believed_and_the_strange_one_is_told_once() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../missions/structure-watch");
        let mut mission = Mission::load(&folder).unwrap();
        mission.forecasts.push(("winds-actual.csv".to_string(), WindField::default()));
        let winds = |name: &str| mission.forecasts.iter().find(|(known, _)| known == name).unwrap().1.clone();
        let mut news = News::default();
        for file in ["winds-actual.csv", "winds-of-mars.csv", "winds-of-mars.csv"] {
            said(&mut news, "new-forecast", &[Value::text(file)]);
        }
        said(&mut news, "new-likelihood", &[Value::symbol("castle"), Value::Real(2.0)]);
        said(&mut news, "target-gone", &[Value::symbol("castle")]);
        let unknown = news.unknown(&mission);
        assert_eq!(unknown.len(), 2, "{unknown:?}");
        assert_eq!(news.believed(&mission).forecast, winds("winds-actual.csv"));
        said(&mut news, "new-forecast", &[Value::text("winds.csv")]);
        said(&mut news, "new-forecast", &[Value::text("winds-of-mars.csv")]);
        assert_eq!(news.believed(&mission).forecast, winds("winds.csv"));
    }
}
