//! The mission score during a flight, by the positions known on board: with a navigation that works, the score of the report if the flight
//! ended at an instant.

use super::flown::FlownScore;
use super::value::{Cost, benefits_of, running_costs};
use crate::situation::Situation;
use crate::{Mission, TargetKind};
use apex_model::effect::Effect;
use apex_model::event::{Batch, EventKind};
use apex_model::time::{Duration, Time};
use apex_observation::result::TargetResult;
use serde::Serialize;
use std::collections::BTreeMap;

/// Longest time for which the ground that a running scanner sees is not counted yet.
const COUNTING_INTERVAL: Duration = Duration(60_000_000_000);

/// The score if the flight ended at an instant, in points.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct ScoreSoFar {
    /// Observations up to this instant count, nanoseconds of mission time: while the scanner is on, the last minute may be missing.
    pub counted_ns: i64,
    /// Points of all looks.
    pub benefits: f64,
    /// Crew, risk of failure, and required looks that are still missing.
    pub costs: f64,
    /// Benefits less costs.
    pub score: f64,
}

/// Benefits from an instant on.
struct CountedBenefits {
    at: Time,
    points: f64,
    missed: f64,
}

/// The score of one flight at all instants until now, computed from its steps.
pub struct ScoreHistory {
    mission: Mission,
    situation: Situation,
    flown: FlownScore,
    /// Targets that must be seen after others: their results depend on those of others.
    ordered: Vec<String>,
    /// Results of each target, with the number of looks in them.
    results: BTreeMap<String, (usize, TargetResult)>,
    counted: Vec<CountedBenefits>,
    /// Number of looks, and values of targets, in the last count.
    looks: usize,
    values: BTreeMap<String, f64>,
}

impl ScoreHistory {
    /// Returns the history before the first observation; `None` for a mission that is not measured by its score.
    ///
    /// # Errors
    /// The ground of a target is invalid.
    pub fn new(mission: Mission) -> Result<Option<ScoreHistory>, String> {
        if !mission.targets.iter().any(|target| matches!(target.kind, TargetKind::Fire(_))) {
            return Ok(None);
        }
        let Some(flown) = FlownScore::new(&mission)?.map(FlownScore::as_known_on_board) else { return Ok(None) };
        let is_ordered = |kind: &TargetKind| matches!(kind, TargetKind::Fire(fire) if !fire.wanted.after.is_empty());
        let ordered =
            mission.targets.iter().filter(|target| is_ordered(&target.kind)).map(|target| target.id.clone()).collect();
        let results = flown.results().into_iter().map(|result| (result.name.clone(), (0, result))).collect();
        let mut history = ScoreHistory {
            mission,
            situation: Situation::default(),
            flown,
            ordered,
            results,
            counted: Vec::new(),
            looks: 0,
            values: BTreeMap::new(),
        };
        history.count(Time::BEGINNING);
        Ok(Some(history))
    }

    /// Processes one step of the agent with this number.
    pub fn observe(&mut self, agent: usize, batch: &Batch, effects: &[Effect]) {
        self.situation.observe(&self.mission, agent, batch, effects);
        if agent != 0 {
            return;
        }
        self.flown.observe(batch);
        let is_said = batch.events.iter().any(|event| matches!(event.kind, EventKind::Occurrence(_)));
        let is_revalued = is_said && self.situation.updates.values() != &self.values;
        let last = self.counted.last().map_or(Time::BEGINNING, |counted| counted.at);
        let is_due = !self.flown.is_scanning() || batch.now - last >= COUNTING_INTERVAL;
        if is_revalued || (is_due && self.look_count() != self.looks) {
            self.count(batch.now);
        }
    }

    /// Returns the score as if the flight had ended at `at`.
    pub fn at(&self, at: Time) -> Option<ScoreSoFar> {
        let counted = self.counted.iter().rev().find(|counted| counted.at <= at)?;
        let hours = at.seconds().max(0.0) / 3600.0;
        let (running, _) = running_costs(&self.mission, hours);
        let costs = counted.missed + running.iter().map(Cost::points).sum::<f64>();
        let counted_ns = counted.at.0.max(0);
        Some(ScoreSoFar { counted_ns, benefits: counted.points, costs, score: counted.points - costs })
    }

    /// Returns the number of looks that cells of all targets have received until now.
    fn look_count(&self) -> usize {
        self.flown.observation().look_counts().map(|(_, looks)| looks).sum()
    }

    /// Computes the benefits again for targets of which more has been seen, and for those that depend on them.
    fn count(&mut self, at: Time) {
        for (name, now) in self.flown.observation().look_counts() {
            let known = self.results.get(name);
            if known.is_none_or(|(looks, _)| now != *looks) || (now > 0 && self.ordered.iter().any(|one| one == name)) {
                // The ground of a growth that was not seen yet has no result, as it has no points.
                if let Some(result) = self.flown.result(name) {
                    self.results.insert(name.to_string(), (now, result));
                }
            }
        }
        self.looks = self.look_count();
        self.values.clone_from(self.situation.updates.values());
        let mission = self.flown.with_growth(self.situation.updates.valued(&self.mission));
        // In the order of the mission's targets, so that sums do not depend on their names.
        let results = mission.targets.iter().filter_map(|target| self.results.get(&target.id));
        let benefits = benefits_of(&mission, results.map(|(_, result)| result.clone()).collect());
        let missed = benefits.missed.iter().map(Cost::points).sum();
        self.counted.push(CountedBenefits { at, points: benefits.points, missed });
    }
}
