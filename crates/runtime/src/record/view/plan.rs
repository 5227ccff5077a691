//! The plan in force: the last one that the executive had adopted by an instant.

use super::RecordView;
use crate::error::RecordError;
use apex_model::effect::{DecisionKind, Effect};
use apex_model::problem::{LeftOut, Plan, Position};
use apex_model::time::Time;
use rusqlite::{Connection, OptionalExtension};
use serde::Serialize;

/// The plan in force at an instant.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct PlanInForce {
    /// Number of plans adopted so far: 1 for the first.
    pub number: i64,
    /// Mission time in nanoseconds of its adoption.
    pub adopted_ns: i64,
    /// One line about it.
    pub summary: String,
    /// Its visits in order, with the times that it predicts.
    pub visits: Vec<PlannedVisit>,
    /// Positions along its way, `[longitude, latitude]` in degrees; empty if it states none.
    pub route: Vec<[f64; 2]>,
    /// The targets that it leaves out.
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
    /// Why.
    pub reason: String,
}

impl RecordView {
    /// The plan in force at mission time `at_ns` (nanoseconds; none means the record's end); none before the first one.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn plan(&self, at_ns: Option<i64>) -> Result<Option<PlanInForce>, RecordError> {
        let at_ns = at_ns.unwrap_or(i64::MAX);
        let adopted = self.query("the plans", |connection| adopted(connection, at_ns))?;
        let Some((number, adopted_ns, summary, text)) = adopted else { return Ok(None) };
        let plan = text.and_then(|text| serde_json::from_str::<Plan>(&text).ok());
        let (visits, route, left_out) = plan.map(shown).unwrap_or_default();
        Ok(Some(PlanInForce { number, adopted_ns, summary, visits, route, left_out }))
    }
}

type Adopted = (i64, i64, String, Option<String>);

fn adopted(connection: &Connection, at_ns: i64) -> rusqlite::Result<Option<Adopted>> {
    let sql = "SELECT t_ns, subject, body, (SELECT count(*) FROM effect WHERE kind = 'procedure-added' AND t_ns <= ?1) \
               FROM effect WHERE kind = 'procedure-added' AND t_ns <= ?1 ORDER BY id DESC LIMIT 1";
    let last = connection
        .prepare_cached(sql)?
        .query_row([at_ns], |row| {
            let body: Vec<u8> = row.get(2)?;
            Ok((row.get::<_, i64>(0)?, row.get::<_, String>(1)?, body, row.get::<_, i64>(3)?))
        })
        .optional()?;
    let Some((adopted_ns, summary, body, number)) = last else { return Ok(None) };
    let request = match postcard::from_bytes(&body) {
        Ok(Effect::Decided(decision)) => match decision.kind {
            DecisionKind::ProcedureAdded { request, .. } => Some(request.0.cast_signed()),
            _ => None,
        },
        // A record of another version: the line about the plan remains.
        Ok(_) | Err(_) => None,
    };
    let plan = connection
        .prepare_cached("SELECT plan FROM answer WHERE request = ?1 ORDER BY position DESC LIMIT 1")?
        .query_row([request], |row| row.get::<_, Option<String>>(0))
        .optional()?;
    Ok(Some((number, adopted_ns, summary, plan.flatten())))
}

type Shown = (Vec<PlannedVisit>, Vec<[f64; 2]>, Vec<LeftOutTarget>);

fn shown(plan: Plan) -> Shown {
    let visit = |target: String, begin_s: f64, end_s: f64| PlannedVisit {
        target,
        begin_ns: Time::from_seconds(begin_s).0,
        end_ns: Time::from_seconds(end_s).0,
    };
    let left_out =
        |list: Vec<LeftOut>| list.into_iter().map(|LeftOut { target, reason }| LeftOutTarget { target, reason });
    match plan {
        Plan::Surveillance(plan) => {
            let visits = plan.visits.into_iter().map(|one| visit(one.target, one.arrive_s, one.end_s)).collect();
            (visits, Vec::new(), left_out(plan.left_out).collect())
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
