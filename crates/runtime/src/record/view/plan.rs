//! The plan in force: the last plan that the executive had adopted by an instant.

use super::RecordView;
use crate::error::RecordError;
use crate::record::Effects;
use apex_model::effect::{Decision, DecisionKind, Effect};
use apex_model::problem::{LeftOut, Obstacle, Plan, Position, SurveillanceVisit, TimeLimit};
use apex_model::time::Time;
use rusqlite::OptionalExtension;
use serde::Serialize;

/// The plan in force at an instant.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct PlanInForce {
    /// Number of plans adopted so far: 1 for the first plan.
    pub number: i64,
    /// Mission time in nanoseconds of its adoption.
    pub adopted_ns: i64,
    /// One line about it.
    pub summary: String,
    /// Its visits in order, with the predicted times.
    pub visits: Vec<PlannedVisit>,
    /// Positions along its route, `[longitude, latitude]` in degrees; empty if the plan states none.
    pub route: Vec<[f64; 2]>,
    /// The targets that the plan leaves out.
    pub left_out: Vec<LeftOutTarget>,
}

/// A planned visit.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct PlannedVisit {
    /// The target's identifier.
    pub target: String,
    /// Predicted begin, nanoseconds of mission time.
    pub begin_ns: i64,
    /// Predicted end, nanoseconds of mission time.
    pub end_ns: i64,
}

/// A target without a visit.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct LeftOutTarget {
    /// The target's identifier.
    pub target: String,
    /// Reason.
    pub reason: String,
    /// Change that a visit would need, by the planner's own arithmetic; none where it states no obstacle as a value, and in records
    /// of earlier versions.
    pub needs: Option<VisitNeed>,
}

/// Change that a visit would need.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum VisitNeed {
    /// Time, or energy for that time.
    Time {
        /// Seconds.
        more_s: f64,
        /// The limit that leaves less: `the end of the mission`, `endurance`.
        limit: String,
        /// True if energy is the limit.
        is_energy: bool,
        /// True if the target cannot be visited as the only one either.
        alone: bool,
    },
    /// Value.
    Value {
        /// Points of the score that a visit would cost; none if any value is missing.
        more: Option<f64>,
    },
    /// A lower cost: a visit would raise the expected cost of ignorance.
    Cost {
        /// Difference of the expected cost.
        more: f64,
    },
    /// A time window that closes later.
    Window,
}

impl VisitNeed {
    /// Returns the change that would remove an obstacle stated by a planner.
    fn of(obstacle: Obstacle) -> VisitNeed {
        match obstacle {
            Obstacle::Late { over_s, limit, alone } => {
                let (limit, is_energy) = match limit {
                    TimeLimit::Flight { name, is_energy, .. } => (name, is_energy),
                    TimeLimit::Horizon => ("the horizon".into(), false),
                    TimeLimit::OtherVisits => ("the time between the others".into(), false),
                };
                VisitNeed::Time { more_s: over_s, limit, is_energy, alone }
            }
            Obstacle::Score { loss } => VisitNeed::Value { more: Some(loss) },
            Obstacle::ExpectedCost { without, with } => VisitNeed::Cost { more: with - without },
            Obstacle::Worthless => VisitNeed::Value { more: None },
            Obstacle::Window => VisitNeed::Window,
        }
    }
}

/// The plans adopted by an instant.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Plans {
    /// By number. Only the last two have their routes.
    pub plans: Vec<PlanInForce>,
    /// Number of earlier plans that are not listed, because there are more than [`PLANS_MAX`].
    pub left_out: i64,
}

/// Maximum number of plans in one answer.
pub const PLANS_MAX: i64 = 100;

impl RecordView {
    /// Returns all plans adopted by mission time `at_ns` (nanoseconds; none means the record's end), the last [`PLANS_MAX`].
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn plans(&self, at_ns: Option<i64>) -> Result<Plans, RecordError> {
        let effects = self.effects()?;
        let added = effects.table.plans(Time(at_ns.unwrap_or(i64::MAX)));
        let total = added.len() as i64;
        let first = (total - PLANS_MAX).max(0) + 1;
        let mut plans = Vec::new();
        for (number, place) in (1..).zip(added).skip(usize::try_from(first - 1).unwrap_or(0)) {
            let mut plan = in_force(self.adopted(&effects, *place, number)?);
            if number + 1 < total {
                plan.route = Vec::new();
            }
            plans.push(plan);
        }
        Ok(Plans { plans, left_out: first - 1 })
    }

    /// Returns the plan in force at mission time `at_ns` (nanoseconds; `None`: the record's end); `None` before the first plan.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn plan(&self, at_ns: Option<i64>) -> Result<Option<PlanInForce>, RecordError> {
        let effects = self.effects()?;
        let added = effects.table.plans(Time(at_ns.unwrap_or(i64::MAX)));
        let last = added.last().map(|place| self.adopted(&effects, *place, added.len() as i64));
        Ok(last.transpose()?.map(in_force))
    }

    /// Returns the plan that was adopted by the effect at `place`.
    fn adopted(&self, effects: &Effects<'_>, place: usize, number: i64) -> Result<Adopted, RecordError> {
        let (request, summary) = match effects.effect(place)? {
            Effect::Decided(Decision { kind: DecisionKind::ProcedureAdded { request, summary, .. }, .. }) => {
                (request.0.cast_signed(), summary)
            }
            _ => return Err(self.reader.garbled("the adoption of a plan is missing".into())),
        };
        let found = self.query("the plans", |connection| {
            let posed = "(SELECT t_ns FROM problem WHERE request = ?1 ORDER BY position DESC LIMIT 1)";
            let sql = format!("SELECT plan, {posed} FROM answer WHERE request = ?1 ORDER BY position DESC LIMIT 1");
            let row = |row: &rusqlite::Row<'_>| Ok((row.get::<_, Option<String>>(0)?, row.get::<_, Option<i64>>(1)?));
            connection.prepare_cached(&sql)?.query_row([request], row).optional()
        })?;
        let adopted_ns = effects.at(place).0;
        let (text, posed_ns) = found.unwrap_or_default();
        Ok(Adopted { number, adopted_ns, posed_ns: posed_ns.unwrap_or(adopted_ns), summary, text })
    }
}

impl PlanInForce {
    /// Returns a plan in the form of the page; its problem was posed at `posed_ns`, and no executive has adopted it.
    pub fn of_plan(plan: Plan, posed_ns: i64) -> PlanInForce {
        let summary = plan.summary().to_owned();
        let (visits, route, left_out) = shown(plan, posed_ns);
        PlanInForce { number: 0, adopted_ns: posed_ns, summary, visits, route, left_out }
    }
}

fn in_force(adopted: Adopted) -> PlanInForce {
    let Adopted { number, adopted_ns, posed_ns, summary, text } = adopted;
    let plan = text.and_then(|text| serde_json::from_str::<Plan>(&text).ok());
    let (visits, route, left_out) = plan.map(|plan| shown(plan, posed_ns)).unwrap_or_default();
    PlanInForce { number, adopted_ns, summary, visits, route, left_out }
}

/// A plan that the executive adopted, as stored.
struct Adopted {
    number: i64,
    adopted_ns: i64,
    /// Instant at which its problem was posed.
    posed_ns: i64,
    summary: String,
    /// The plan as JSON.
    text: Option<String>,
}

type Shown = (Vec<PlannedVisit>, Vec<[f64; 2]>, Vec<LeftOutTarget>);

/// Returns the parts of a plan whose problem was posed at `posed_ns`: times of surveillance plans count from then, those of single visits
/// are mission times.
fn shown(plan: Plan, posed_ns: i64) -> Shown {
    let visit = |target: String, begin_s: f64, end_s: f64| PlannedVisit {
        target,
        begin_ns: Time::from_seconds(begin_s).0,
        end_ns: Time::from_seconds(end_s).0,
    };
    let left_out = |list: Vec<LeftOut>| {
        list.into_iter().map(|LeftOut { target, reason, obstacle }| {
            let needs = obstacle.map(VisitNeed::of);
            LeftOutTarget { target, reason, needs }
        })
    };
    match plan {
        Plan::Surveillance(plan) => {
            let posed_s = Time(posed_ns).seconds();
            let later = |one: SurveillanceVisit| visit(one.target, posed_s + one.arrive_s, posed_s + one.end_s);
            (plan.visits.into_iter().map(later).collect(), Vec::new(), left_out(plan.left_out).collect())
        }
        Plan::SingleVisit(plan) => {
            let flown = |path: &[Position], route: &[Position]| -> Vec<[f64; 2]> {
                let way = if path.is_empty() { route } else { path };
                way.iter().map(|position| [position.longitude_deg, position.latitude_deg]).collect()
            };
            let mut route: Vec<[f64; 2]> = plan.visits.iter().flat_map(|one| flown(&one.path, &one.route)).collect();
            route.extend(flown(&plan.return_path, &plan.return_route));
            let visits = plan.visits.into_iter().map(|one| visit(one.target, one.begin_s, one.end_s)).collect();
            (visits, route, left_out(plan.left_out).collect())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_model::problem::SurveillancePlan;

    fn needs(left_out: &str) -> Option<VisitNeed> {
        let plan = format!(
            r#"{{"solver": "x", "cycle": [], "visits": [], "return_s": null, "expected_cost": 1.0, "expected_cost_bound": null,
                "left_out": [{left_out}], "summary": ""}}"#
        );
        let plan: SurveillancePlan = serde_json::from_str(&plan).unwrap();
        PlanInForce::of_plan(Plan::Surveillance(plan), 0).left_out.pop().unwrap().needs
    }

    #[test]
    fn needs_are_those_of_the_obstacle_and_never_read_from_the_text() {
        let late = |limit: &str| {
            let obstacle = format!(r#"{{"Late": {{"over_s": 90.25, "limit": {limit}, "alone": true}}}}"#);
            needs(&format!(r#"{{"target": "barn", "reason": "needs 2 min more", "obstacle": {obstacle}}}"#))
        };
        let time = |limit: &str, is_energy| {
            Some(VisitNeed::Time { more_s: 90.25, limit: limit.into(), is_energy, alone: true })
        };
        let flight = |name: &str, is_energy: bool| {
            late(&format!(r#"{{"Flight": {{"name": "{name}", "cause": null, "is_energy": {is_energy}}}}}"#))
        };
        assert_eq!(flight("the cells", true), time("the cells", true));
        assert_eq!(flight("the closing of the fuel depot", false), time("the closing of the fuel depot", false));
        assert_eq!(late(r#""Horizon""#), time("the horizon", false));
        // A plan of a record of an earlier version.
        assert_eq!(needs(r#"{"target": "barn", "reason": "needs 2 min more than endurance leaves"}"#), None);
    }
}
