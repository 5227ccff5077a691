//! Visits under storms: requests a new plan if a storm will be over a visit that is planned, or has left one that is not.

use crate::storm::StormMemory;
use crate::{Mission, TargetKind};
use apex_model::event::EventKind;
use apex_model::problem::{Plan, PlannedVisit, Position, QualityFactor};
use apex_model::time::Time;
use apex_model::value::Value;
use apex_runtime::ports::Input;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// Interval between comparisons.
const PERIOD_S: f64 = 60.0;
/// A new plan for the same visit is requested at most this often.
const AGAIN_S: f64 = 900.0;
/// A visit that begins within this time is next: the aircraft is on the way to it, and plans at once.
const NEXT_S: f64 = 1_200.0;
/// A storm has left a place if it does not return within this time.
const GONE_S: f64 = 1_800.0;
/// Distance of a visit from the edge of a cell that is too near: less than plans keep.
const NEAR_M: f64 = 3_000.0;

/// Visits for which new plans were requested.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct StormyVisits {
    compared_s: Option<f64>,
    /// Instant of the last request for each look.
    asked_s: BTreeMap<String, f64>,
    /// Looks over which a storm was expected when the plan was made that states something about them last.
    expected: BTreeSet<String>,
}

/// A plan with the instant of its request, and the looks that were observed.
type FlownPlan<'a> = (&'a Plan, f64, &'a [&'a str]);

impl StormyVisits {
    /// Compares the plan with the storms, in flights that avoid them; returns notes for the report, and a request for a new plan.
    pub(super) fn compare(
        &mut self,
        (mission, storms): (&Mission, &StormMemory),
        (plan, made_s, observed): FlownPlan<'_>,
        now: Time,
    ) -> (Vec<String>, Option<Input>) {
        let now_s = now.seconds();
        let is_due = self.compared_s.is_none_or(|at_s| now_s - at_s >= PERIOD_S);
        if !storms.is_avoiding() || !is_due {
            return (Vec::new(), None);
        }
        self.compared_s = Some(now_s);
        let is_asked =
            |name: &str| !observed.contains(&name) && self.asked_s.get(name).is_none_or(|at_s| now_s - at_s >= AGAIN_S);
        let covered = |name: &str, span_s: (f64, f64)| {
            place_of(mission, name).is_some_and(|(place, radius_m)| storms.is_near(place, radius_m + NEAR_M, span_s))
        };
        let mut news: Vec<(String, bool, String)> = Vec::new();
        for (name, begin_s, end_s) in visits(plan, made_s).into_iter().filter(|(name, ..)| is_asked(name)) {
            let span_s = (begin_s.max(now_s), end_s.max(now_s));
            if covered(&name, span_s) {
                let note = format!("a storm will be over {name} at {}", Time::from_seconds(span_s.0.round()));
                news.push((name, begin_s < now_s + NEXT_S, note));
            }
        }
        for left_out in plan.left_out().iter().filter(|left_out| is_asked(&left_out.target)) {
            let name = &left_out.target;
            if self.expected.contains(name) && !covered(name, (now_s, now_s + GONE_S)) {
                news.push((name.clone(), false, format!("the storm has left {name}")));
            }
        }
        // One plan takes account of all of them.
        let is_urgent = news.iter().any(|(_, is_next, _)| *is_next);
        let head = Value::symbol(if is_urgent { "off-schedule" } else { "violated" });
        let first = news.iter().find(|(_, is_next, _)| *is_next == is_urgent);
        let input = first.map(|(name, ..)| {
            let what = Value::list([Value::symbol("storm"), Value::symbol(name)]);
            Input::new(now, EventKind::Occurrence(Value::list([head, what])))
        });
        self.asked_s.extend(news.iter().map(|(name, ..)| (name.clone(), now_s)));
        (news.into_iter().map(|(_, _, note)| note).collect(), input)
    }

    /// Returns the addition to the state of a target in a new plan if a storm is expected over it, for a visit before the visit begins.
    pub(super) fn expect(
        &mut self,
        (mission, storms): (&Mission, &StormMemory),
        name: &str,
        (now, begin_s): (Time, f64),
    ) -> String {
        let place = place_of(mission, name).filter(|_| storms.is_avoiding());
        let found = place.and_then(|(position, radius_m)| storms.spell(position, radius_m + NEAR_M, now.seconds()));
        let Some((from_s, until_s)) = found.filter(|(from_s, _)| *from_s < begin_s) else {
            self.expected.remove(name);
            return String::new();
        };
        self.expected.insert(name.to_string());
        let shown = |at_s: f64| Time::from_seconds(at_s.round());
        match until_s {
            Some(until_s) => format!("; a storm is expected over it from {} to {}", shown(from_s), shown(until_s)),
            None => format!("; a storm is expected over it from {} on", shown(from_s)),
        }
    }
}

/// Returns the looks of a plan with the begin and the end of each.
fn visits(plan: &Plan, made_s: f64) -> Vec<(String, f64, f64)> {
    match plan {
        Plan::SingleVisit(plan) => {
            plan.visits.iter().map(|visit| (visit.target.clone(), visit.begin_s, visit.end_s)).collect()
        }
        Plan::Surveillance(plan) => {
            let at = |arrive_s: f64| made_s + arrive_s;
            plan.visits.iter().map(|visit| (visit.target.clone(), at(visit.arrive_s), at(visit.arrive_s))).collect()
        }
    }
}

/// Returns the position and the radius of the target of a look.
fn place_of(mission: &Mission, look: &str) -> Option<(Position, f64)> {
    let id = look.split('/').next().unwrap_or(look);
    let target = mission.targets.iter().find(|target| target.id == id)?;
    let radius_m = if let TargetKind::Fire(fire) = &target.kind { fire.radius_m } else { 0.0 };
    Some((target.position, radius_m))
}

/// Returns the looks of a plan, the detail of the state of each, `for 9:30:00`, and its begin.
pub(super) fn planned_visits(plan: &Plan, made_s: f64) -> Vec<(String, String, f64)> {
    let planned = |begin_s: f64| format!("for {}", Time::from_seconds(begin_s.round()));
    let of_visit = |visit: &PlannedVisit| match visit.quality.as_ref().map(|quality| &quality.coverage) {
        Some(QualityFactor { factor, cause }) if (100.0 * factor).round() < 100.0 => {
            format!("{}; coverage {:.0} %: {cause}", planned(visit.begin_s), 100.0 * factor)
        }
        _ => planned(visit.begin_s),
    };
    let details: Vec<String> = match plan {
        Plan::SingleVisit(plan) => plan.visits.iter().map(of_visit).collect(),
        // Times of these plans count from the instant at which the problem was posed.
        Plan::Surveillance(plan) => plan.visits.iter().map(|visit| planned(made_s + visit.arrive_s)).collect(),
    };
    visits(plan, made_s).into_iter().zip(details).map(|((name, begin_s, _), detail)| (name, detail, begin_s)).collect()
}
