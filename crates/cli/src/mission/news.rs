//! News in flight: what is said of targets and of the weather after the start, and the mission as it is believed since.
//!
//! Events are read off the record's inputs, so planning again in replay believes the same (docs/reference/mission-data.md, "News in flight").

use super::{Mission, TargetKind};
use apex_model::problem::{CostFunction, EventRate};
use apex_model::value::Value;
use apex_solvers::human::Human;
use std::collections::BTreeMap;

const SECONDS_PER_HOUR: f64 = 3600.0;

/// What has been said so far; the last word on a target counts.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct News {
    /// Targets announced during the flight, by `(new-target ID)`.
    announced: Vec<String>,
    /// Targets that need no observation any more, by `(target-gone ID)`.
    gone: Vec<String>,
    /// Worth of fires and importance of structures, by `(new-value ID NUMBER)`.
    values: BTreeMap<String, f64>,
    /// Events per hour, by `(new-likelihood ID NUMBER)`.
    rates_per_h: BTreeMap<String, f64>,
    /// The file of the forecast that is believed, by `(new-forecast FILE)`; none is the first.
    forecast: Option<String>,
    /// What a person wants, by `(planned-by-people ([repeat] TARGET ..))`.
    visits: Option<Human>,
}

impl News {
    /// Takes an event. Nothing when it is no news, else a line for the report.
    pub fn take(&mut self, head: &str, items: &[Value]) -> Option<String> {
        let subject = items.first().map(name)?;
        let number = || items.get(1).and_then(Value::as_number).map(|(number, _)| number);
        let amount = || number().filter(|number| number.is_finite() && *number >= 0.0);
        let unread = || Some(format!("({head} {subject} ..) is without a number from 0 on, and changes nothing"));
        match head {
            "new-target" => {
                self.gone.retain(|known| *known != subject);
                let note = format!("new target: {subject}");
                self.announced.push(subject);
                Some(note)
            }
            "target-gone" => {
                let note = format!("no target any more: {subject}");
                self.gone.push(subject);
                Some(note)
            }
            "new-value" => {
                let Some(value) = amount() else { return unread() };
                let note = format!("{subject} is worth {value} from now on");
                self.values.insert(subject, value);
                Some(note)
            }
            "new-likelihood" => {
                let Some(rate_per_h) = amount() else { return unread() };
                let note = format!("{subject}: {rate_per_h} events an hour from now on");
                self.rates_per_h.insert(subject, rate_per_h);
                Some(note)
            }
            "new-forecast" => {
                let note = format!("new forecast: {subject}");
                self.forecast = Some(subject);
                Some(note)
            }
            "planned-by-people" => {
                let mut visits: Vec<String> = items.first().and_then(Value::as_list)?.iter().map(name).collect();
                let note = format!("planned by people: {}", visits.join(", "));
                let repeat = visits.first().is_some_and(|first| first == "repeat");
                visits.drain(..usize::from(repeat));
                self.visits = Some(Human { visits, repeat });
                Some(note)
            }
            _ => None,
        }
    }

    /// True when the target has been announced.
    pub fn is_announced(&self, target: &str) -> bool {
        self.announced.iter().any(|known| known == target)
    }

    /// The visits that a person wants.
    pub fn visits(&self) -> Option<&Human> {
        self.visits.as_ref()
    }

    /// What of it names nothing of the mission, in words.
    pub fn unknown(&self, mission: &Mission) -> Vec<String> {
        let target = |id: &&String| !mission.targets.iter().any(|target| target.id == **id);
        let named = self.announced.iter().chain(&self.gone).chain(self.values.keys()).chain(self.rates_per_h.keys());
        let targets = named.filter(target).map(|id| format!("{id} is no target of this mission"));
        let file = |name: &&String| !mission.forecasts.iter().any(|(known, _)| known == *name);
        let forecasts = self.forecast.iter().filter(file).map(|name| {
            let known: Vec<&str> = mission.forecasts.iter().map(|(known, _)| known.as_str()).collect();
            format!("{name} is none of the mission's forecasts, {}", known.join(", "))
        });
        targets.chain(forecasts).collect()
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
        let forecast = self
            .forecast
            .as_ref()
            .and_then(|name| mission.forecasts.iter().find(|(known, _)| known == name).map(|(_, wind)| wind.clone()));
        believed.forecast = forecast.unwrap_or(believed.forecast);
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
        for bad in [Value::Real(-1.0), Value::Real(f64::NAN), Value::symbol("much")] {
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
        assert_eq!(news.gone, ["barn"]);
        said(&mut news, "new-target", &barn);
        assert!(news.gone.is_empty() && news.is_announced("barn"));
    }
}
