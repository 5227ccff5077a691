//! Updates in flight: new data of targets and weather after the start, and the mission as it is assumed since
//! (docs/reference/mission-data.md, "Changes in flight").

use crate::{Fire, Mission, TargetKind};
use apex_model::planned::Location;
use apex_model::problem::{CostFunction, EventRate, Position, WindField};
use apex_model::quantity::Dimension;
use apex_model::value::Value;
use apex_runtime::target_state::{NEW_VALUE, TARGET_VALUE_MAX};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

const SECONDS_PER_HOUR: f64 = 3600.0;
/// Greatest rate of events at a structure: as in the mission's files.
const RATE_PER_H_MAX: f64 = 1e6;
/// Maximum number of corners of an outline.
const CORNERS_MAX: usize = 2_000;

/// An update of the mission's data, from one message.
#[derive(Clone, Debug, PartialEq)]
pub enum MissionUpdate {
    /// `(new-target ID)`.
    NewTarget(String),
    /// `(target-gone ID)`: the target no longer needs an observation.
    TargetGone {
        /// Its id.
        target: String,
        /// The id as printed in the message.
        printed: String,
    },
    /// `(new-value ID NUMBER)`: the value of a fire, or the importance of a structure.
    NewValue(String, f64),
    /// `(new-likelihood ID NUMBER)`: events per hour at a structure.
    NewLikelihood(String, f64),
    /// `(new-perimeter ID ((LATITUDE LONGITUDE) ..))`: the outline of a fire.
    NewPerimeter(String, Vec<Position>),
    /// `(new-forecast FILE)`.
    NewForecast(String),
    /// `(planned-by-people ([repeat] TARGET ..))`; without visits it withdraws an earlier plan of the operator.
    OperatorPlan {
        /// Targets in order.
        visits: Vec<String>,
        /// The visits form a cycle.
        repeat: bool,
        /// The message's items as printed.
        printed: String,
    },
    /// `(plan-imposed (TARGET ..))`: later requests for plans are answered with those of these visits that are still open; without
    /// targets planners plan again.
    PlanImposed(Vec<String>),
    /// A message of one of these forms that lacks its number: it changes nothing.
    Invalid(String),
}

impl MissionUpdate {
    /// Reads the message `(HEAD ITEM..)`; `None` if it is another message.
    pub fn read(head: &str, items: &[Value]) -> Option<MissionUpdate> {
        let first = items.first()?;
        let subject = name(first);
        let amount = |most: f64, update: fn(String, f64) -> MissionUpdate| {
            let number = items.get(1).and_then(Value::as_number).filter(|(_, dimension)| *dimension == Dimension::NONE);
            match number.map(|(number, _)| number).filter(|number| (0.0..=most).contains(number)) {
                Some(number) => update(subject.clone(), number),
                None => MissionUpdate::Invalid(format!(
                    "({head} {subject} ..) has no number from 0 to {most}, and is ignored"
                )),
            }
        };
        Some(match head {
            "new-target" => MissionUpdate::NewTarget(subject),
            "target-gone" => MissionUpdate::TargetGone { target: subject, printed: first.to_string() },
            NEW_VALUE => amount(TARGET_VALUE_MAX, MissionUpdate::NewValue),
            "new-likelihood" => amount(RATE_PER_H_MAX, MissionUpdate::NewLikelihood),
            "new-forecast" => MissionUpdate::NewForecast(subject),
            "new-perimeter" => match items.get(1).and_then(outline) {
                Some(outline) => MissionUpdate::NewPerimeter(subject, outline),
                None => MissionUpdate::Invalid(format!(
                    "({head} {subject} ..) has no outline of 3 to {CORNERS_MAX} places, and is ignored"
                )),
            },
            "planned-by-people" => {
                let said = first.as_list().unwrap_or_default();
                let mut visits: Vec<String> = said.iter().map(name).collect();
                let repeat = visits.first().is_some_and(|first| first == "repeat");
                visits.drain(..usize::from(repeat));
                let printed: Vec<String> = items.iter().map(Value::to_string).collect();
                MissionUpdate::OperatorPlan { visits, repeat, printed: printed.join(" ") }
            }
            "plan-imposed" => {
                MissionUpdate::PlanImposed(first.as_list().unwrap_or_default().iter().map(name).collect())
            }
            _ => return None,
        })
    }
}

/// All updates so far; the last one about a target counts.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MissionUpdates {
    /// Targets announced during the flight.
    announced: BTreeSet<String>,
    /// Targets that need no observation any longer.
    gone: BTreeSet<String>,
    /// Values of fires and importance of structures.
    values: BTreeMap<String, f64>,
    /// Events per hour.
    rates_per_h: BTreeMap<String, f64>,
    /// Outlines of fires.
    perimeters: BTreeMap<String, Vec<Position>>,
    /// Files of forecasts in the order of their last announcement; the last one that the mission contains counts.
    forecasts: Vec<String>,
    /// The operator's plan.
    operator_plan: Option<OperatorPlan>,
    /// Visits that answer every request for a plan.
    imposed: Vec<String>,
}

/// End of the sentence about a name that no target has.
const NO_TARGET: &str = "is not a target of this mission";

/// Visits that the operator wants.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct OperatorPlan {
    /// Targets in order.
    pub visits: Vec<String>,
    /// The visits form a cycle.
    pub repeat: bool,
}

impl MissionUpdates {
    /// Applies an update; returns a line for the report.
    pub fn apply(&mut self, update: MissionUpdate) -> String {
        match update {
            MissionUpdate::NewTarget(target) => {
                self.gone.remove(&target);
                let note = format!("new target: {target}");
                self.announced.insert(target);
                note
            }
            MissionUpdate::TargetGone { target, .. } => {
                let note = format!("no longer a target: {target}");
                self.gone.insert(target);
                note
            }
            MissionUpdate::NewValue(target, value) => {
                let note = format!("{target} is worth {value} from now on");
                self.values.insert(target, value);
                note
            }
            MissionUpdate::NewLikelihood(target, rate_per_h) => {
                let note = format!("{target}: {rate_per_h} events per hour counted for the whole mission");
                self.rates_per_h.insert(target, rate_per_h);
                note
            }
            MissionUpdate::NewPerimeter(target, outline) => {
                let hectares = crate::features::area_m2(&outline) / 1e4;
                let note = format!("{target} burns on {hectares:.0} ha");
                self.perimeters.insert(target, outline);
                note
            }
            MissionUpdate::NewForecast(file) => {
                let note = format!("new forecast: {file}");
                self.forecasts.retain(|known| *known != file);
                self.forecasts.push(file);
                note
            }
            MissionUpdate::OperatorPlan { visits, printed, .. } if visits.is_empty() => {
                self.operator_plan = None;
                format!("planned by an operator: {printed}, which names no visits")
            }
            MissionUpdate::OperatorPlan { visits, repeat, .. } => {
                let again = if repeat { ", again and again" } else { "" };
                let note = format!("planned by an operator: {}{again}", visits.join(", "));
                self.operator_plan = Some(OperatorPlan { visits, repeat });
                note
            }
            MissionUpdate::PlanImposed(visits) => {
                let note = match visits.as_slice() {
                    [] => "planners plan again".to_string(),
                    visits => format!("imposed plan: {}", visits.join(", ")),
                };
                self.imposed = visits;
                note
            }
            MissionUpdate::Invalid(note) => note,
        }
    }

    /// Returns true when the target has been announced.
    pub fn is_announced(&self, target: &str) -> bool {
        self.announced.contains(target)
    }

    /// Returns the visits that answer every request for a plan; empty if planners plan.
    pub fn imposed(&self) -> &[String] {
        &self.imposed
    }

    /// Returns the operator's plan.
    pub fn operator_plan(&self) -> Option<&OperatorPlan> {
        self.operator_plan.as_ref()
    }

    /// Returns a line for the report about an update of something that the mission does not have; `None` for any other update.
    pub fn without_subject(update: &MissionUpdate, mission: &Mission) -> Option<String> {
        match update {
            MissionUpdate::NewTarget(target)
            | MissionUpdate::TargetGone { target, .. }
            | MissionUpdate::NewValue(target, _)
            | MissionUpdate::NewLikelihood(target, _)
            | MissionUpdate::NewPerimeter(target, _) => {
                let is_known = mission.targets.iter().any(|known| known.goes_by(target));
                (!is_known).then(|| format!("{target} {NO_TARGET}"))
            }
            _ => None,
        }
    }

    /// Returns as text the parts of the update that name nothing of the mission, or properties that the target cannot have.
    pub fn unknown(&self, mission: &Mission) -> Vec<String> {
        let find = |id: &String| mission.targets.iter().find(|target| target.goes_by(id));
        let named = self.announced.iter().chain(&self.gone).chain(self.values.keys()).chain(self.rates_per_h.keys());
        let named = named.chain(self.perimeters.keys());
        let strange: BTreeSet<&String> = named.filter(|id| find(id).is_none()).collect();
        let targets = strange.into_iter().map(|id| format!("{id} {NO_TARGET}"));
        let calm = |id: &&String| find(id).is_some_and(|target| !matches!(target.kind, TargetKind::Site(_)));
        let likely = self.rates_per_h.keys().filter(calm);
        let likely = likely.map(|id| format!("{id} is not a structure, and has no likelihood"));
        let file = |name: &&String| !mission.forecasts.iter().any(|(known, _)| known == *name);
        let forecasts = self.forecasts.iter().filter(file).map(|name| {
            let known: Vec<&str> = mission.forecasts.iter().map(|(known, _)| known.as_str()).collect();
            format!("{name} is not one of the mission's forecasts, {}", known.join(", "))
        });
        targets.chain(likely).chain(forecasts).collect()
    }

    /// Returns the mission as assumed after the updates, with the present targets and winds.
    pub fn believed(&self, mission: &Mission) -> Mission {
        let mut believed = self.valued(mission);
        believed.targets.retain(|target| {
            let hidden = target.announced_late && !self.is_announced(&target.id);
            !hidden && !self.gone.contains(&target.id)
        });
        believed
    }

    /// Returns the last announced value of each target.
    pub(crate) fn values(&self) -> &BTreeMap<String, f64> {
        &self.values
    }

    /// Returns the mission with all of its targets, their last announced values, and the assumed forecast.
    pub fn valued(&self, mission: &Mission) -> Mission {
        let mut believed = mission.clone();
        for target in &mut believed.targets {
            if let Some(outline) = self.perimeters.get(&target.id) {
                target.grow(outline, mission.terrain.as_ref());
            }
            let (value, rate_per_h) = (self.values.get(&target.id), self.rates_per_h.get(&target.id));
            match &mut target.kind {
                TargetKind::Fire(fire) => revalue(&target.id, fire, &self.values),
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
        if !self.forecasts.is_empty() {
            believed.forecast = self.forecast(mission).clone();
        }
        believed
    }

    /// Returns the forecast that is assumed.
    pub fn forecast<'a>(&self, mission: &'a Mission) -> &'a WindField {
        let known = |name: &String| mission.forecasts.iter().find(|(known, _)| known == name);
        self.forecasts.iter().rev().find_map(known).map_or(&mission.forecast, |(_, forecast)| forecast)
    }
}

/// Sets the last announced values of a fire, or of its looks by their names.
fn revalue(id: &str, fire: &mut Fire, said: &BTreeMap<String, f64>) {
    if let Some(value) = said.get(id) {
        let (before, count) = (fire.value(), fire.wanted.looks.len().max(1) as f64);
        for look in &mut fire.wanted.looks {
            look.value = if before > 0.0 { look.value / before * value } else { value / count };
        }
    }
    for look in &mut fire.wanted.looks {
        look.value = said.get(&format!("{id}/{}", look.name)).copied().unwrap_or(look.value);
    }
}

/// Reads the outline of a fire in a message; `None` unless it is a list of 3 to [`CORNERS_MAX`] places.
pub(crate) fn outline(value: &Value) -> Option<Vec<Position>> {
    let corners = value.as_list().filter(|corners| (3..=CORNERS_MAX).contains(&corners.len()))?;
    let is_on_map = |at: &Position| at.latitude_deg.abs() <= 89.9 && at.longitude_deg.abs() <= 360.0;
    corners.iter().map(|corner| Some(Location::from_value(corner)?.position).filter(is_on_map)).collect()
}

/// Returns a name in an event: a symbol or a text.
fn name(value: &Value) -> String {
    match value {
        Value::Text(text) => text.to_string(),
        Value::Symbol(symbol) => symbol.folded().to_string(),
        other => other.to_string(),
    }
}

/// Returns the cost of an event that is never found: the last cost of a table; for a formula `of_families`, the stated importance.
fn importance(cost: &CostFunction, of_families: f64) -> f64 {
    match cost {
        CostFunction::Table { points } => points.last().map_or(0.0, |(_, cost)| *cost),
        CostFunction::Delayed { cost, .. } => importance(cost, of_families),
        _ => of_families,
    }
}

/// Returns the cost multiplied by `factor`.
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

    fn said(updates: &mut MissionUpdates, head: &str, items: &[Value]) -> String {
        MissionUpdate::read(head, items).map(|update| updates.apply(update)).unwrap_or_default()
    }

    #[test]
    fn a_message_that_is_not_an_update_changes_nothing() {
        assert_eq!(MissionUpdate::read("observed", &[Value::symbol("barn")]), None);
        assert_eq!(MissionUpdate::read("new-target", &[]), None);
    }

    #[test]
    fn a_value_that_is_invalid_changes_nothing_and_is_reported() {
        let mut updates = MissionUpdates::default();
        let barn = Value::Symbol(Symbol::new("barn"));
        let long = Value::Duration(apex_model::time::Duration::from_seconds(60.0));
        for bad in [Value::Real(-1.0), Value::Real(f64::NAN), Value::Real(2e9), Value::symbol("much"), long] {
            assert!(said(&mut updates, "new-value", &[barn.clone(), bad]).contains("is ignored"));
        }
        assert!(said(&mut updates, "new-likelihood", &[barn]).contains("is ignored"));
        assert_eq!(updates, MissionUpdates::default());
    }

    #[test]
    fn a_target_that_is_announced_again_is_back() {
        let mut updates = MissionUpdates::default();
        let barn = [Value::symbol("barn")];
        said(&mut updates, "target-gone", &barn);
        assert!(updates.gone.contains("barn"));
        said(&mut updates, "new-target", &barn);
        assert!(updates.gone.is_empty() && updates.is_announced("barn"));
    }

    #[test]
    fn an_answer_that_names_no_visits_takes_the_older_one_back() {
        let barn = Value::list([Value::symbol("repeat"), Value::symbol("barn")]);
        let empty =
            [vec![Value::symbol("nobody")], vec![Value::list([])], vec![Value::list([Value::symbol("repeat")])]];
        for empty in empty {
            let mut updates = MissionUpdates::default();
            assert_eq!(
                said(&mut updates, "planned-by-people", std::slice::from_ref(&barn)),
                "planned by an operator: barn, again and again"
            );
            assert_eq!(updates.operator_plan(), Some(&OperatorPlan { visits: vec!["barn".to_string()], repeat: true }));
            let note = said(&mut updates, "planned-by-people", &empty);
            assert!(note.ends_with("which names no visits"), "{note}");
            assert_eq!(updates.operator_plan(), None, "{note}");
        }
    }

    #[test]
    fn the_last_word_that_the_mission_knows_is_used_and_an_unknown_one_is_reported_once() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../missions/structure-watch");
        let mut mission = Mission::load(&folder).unwrap();
        mission.forecasts.push(("winds-actual.csv".to_string(), WindField::default()));
        let winds = |name: &str| mission.forecasts.iter().find(|(known, _)| known == name).unwrap().1.clone();
        let mut updates = MissionUpdates::default();
        for file in ["winds-actual.csv", "winds-of-mars.csv", "winds-of-mars.csv"] {
            said(&mut updates, "new-forecast", &[Value::text(file)]);
        }
        let subject = |head: &str, target: &str| {
            let items = [Value::symbol(target), Value::Real(2.0)];
            MissionUpdates::without_subject(&MissionUpdate::read(head, &items).unwrap(), &mission)
        };
        assert_eq!(subject("new-value", "castle").as_deref(), Some("castle is not a target of this mission"));
        assert_eq!((subject("new-value", "winery"), subject("target-gone", "winery")), (None, None));
        said(&mut updates, "new-likelihood", &[Value::symbol("castle"), Value::Real(2.0)]);
        said(&mut updates, "target-gone", &[Value::symbol("castle")]);
        let unknown = updates.unknown(&mission);
        assert_eq!(unknown.len(), 2, "{unknown:?}");
        assert_eq!(updates.believed(&mission).forecast, winds("winds-actual.csv"));
        said(&mut updates, "new-forecast", &[Value::text("winds.csv")]);
        said(&mut updates, "new-forecast", &[Value::text("winds-of-mars.csv")]);
        assert_eq!(updates.believed(&mission).forecast, winds("winds.csv"));
    }
}
