//! Many flights of one mission, each in a world from another seed: the distribution of results, and the causes of losses.

use crate::ignorance::IgnoranceSummary;
use crate::world::world;
use apex_mission::Mission;
use apex_mission::deliberation::PlanningResources;
use apex_mission::error::{MissionError, MissionResult};
use apex_mission::flight::{FlightOutcome, MissionFlight};
use apex_mission::realised::{FireLog, RealisedIgnorance};
use apex_mission::report::MissionValue;
use apex_mission::verification::{CheckResult, FlightCheck};
use apex_model::time::Time;
use apex_portfolio::parallel;
use apex_runtime::ports::Observer;
use apex_runtime::{Control, EndReason};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;

/// Greatest number of flights in one series.
pub const RUNS_MAX: usize = 1_000_000;
/// Maximum number of threads.
pub const JOBS_MAX: usize = 1_024;

/// Selection of flights.
#[derive(Clone, Debug)]
pub struct RunTerms {
    /// Seed of the first flight; each further flight uses the next number. `None`: the mission's own seed.
    pub first_seed: Option<u64>,
    /// Number of flights, 1 to [`RUNS_MAX`].
    pub runs: usize,
    /// Threads, 1 to [`JOBS_MAX`]. The results do not depend on their number.
    pub jobs: usize,
    /// Mission time at which a flight ends at the latest; `None` is the mission's duration.
    pub until: Option<Time>,
}

/// Outcome of a flight.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum RunOutcome {
    /// The initial task succeeded.
    Completed,
    /// The flight ended otherwise: its task failed, time ran out, or nothing more could happen.
    Lost,
    /// The flight could not be flown to an end: its reason is an error.
    Error,
}

impl RunOutcome {
    /// Returns the word in tables.
    pub fn word(self) -> &'static str {
        match self {
            RunOutcome::Completed => "completed",
            RunOutcome::Lost => "lost",
            RunOutcome::Error => "error",
        }
    }
}

/// One flight of a series.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunRow {
    /// Seed of the flight's world: `apex fly MISSION --seed SEED` repeats the flight.
    pub seed: u64,
    /// Outcome.
    pub outcome: RunOutcome,
    /// Reason for the end.
    pub reason: String,
    /// Mission time of the end, s.
    pub end_s: f64,
    /// Points of the mission score; `None` for surveillance and for flights that cannot be scored.
    pub score: Option<f64>,
    /// Points of the looks that were seen, before costs.
    pub benefits: Option<f64>,
    /// Expected cost of ignorance, of surveillance; less is better.
    pub expected_cost: Option<f64>,
    /// Fires that broke out at structures until the horizon; `None` without a world file that has ignitions.
    pub fires: Option<u64>,
    /// Number of these fires seen before the horizon.
    pub fires_seen: Option<u64>,
    /// Cost of these fires, from their ages when they became known.
    pub realised_cost: Option<f64>,
    /// Expected cost of ignorance for the same visits at the rates stated in the mission: over many seeds the mean of `realised_cost`
    /// approaches it.
    pub expected_cost_stated: Option<f64>,
    /// Visits that ended, and targets that were observed without a visit, by pictures alone.
    pub observed: u64,
    /// Targets that were never observed.
    pub left_out: u64,
    /// Segments that were flown again.
    pub reflies: u64,
    /// Plans that were adopted.
    pub plans: u64,
    /// Checked positions in the air, by the same checks as `apex verify`.
    pub positions: u64,
    /// Number of these positions inside active restricted zones.
    pub inside_zones: u64,
    /// Number of these positions outside of the permitted area.
    pub outside_permitted: u64,
    /// Number of these positions too near to the ground, without take-off, landing and climbs.
    pub near_ground: u64,
    /// Number of these positions beyond the required landing distance.
    pub beyond_landing_distance: u64,
    /// Requirements whose unavoidable violation the flight announced.
    pub said_broken: u64,
    /// Statement about a vehicle that did not land, or that crashed; `None` if it is on the ground.
    pub not_landed: Option<String>,
    /// True if the program ended the flight before the end of its initial task, as after an early landing.
    pub ended_early: bool,
}

impl RunRow {
    fn flown(seed: u64, flight: &FlightOutcome, check: &CheckResult, fires: Option<RealisedIgnorance>) -> RunRow {
        let report = &flight.report;
        let (mut score, mut benefits, mut expected_cost) = (None, None, None);
        match &report.value {
            MissionValue::Score(value) if value.trouble.is_empty() => {
                (score, benefits) = (Some(value.score), Some(value.benefits));
            }
            MissionValue::Ignorance(cost, _) => expected_cost = Some(cost.total),
            MissionValue::Score(_) | MissionValue::None => {}
        }
        let reason = flight.end.reason.text();
        let is_done = flight.end.reason.is_success();
        RunRow {
            seed,
            outcome: if is_done { RunOutcome::Completed } else { RunOutcome::Lost },
            reason,
            end_s: flight.end.at.seconds(),
            score,
            benefits,
            expected_cost,
            fires: fires.map(|fires| fires.fires as u64),
            fires_seen: fires.map(|fires| fires.seen as u64),
            realised_cost: fires.map(|fires| fires.realised),
            expected_cost_stated: fires.map(|fires| fires.expected),
            observed: report.observed as u64,
            left_out: report.left_out.len() as u64,
            reflies: report.visits.iter().map(|visit| u64::from(visit.reflies)).sum(),
            plans: u64::from(report.plans),
            positions: check.positions,
            inside_zones: check.inside_zones,
            outside_permitted: check.outside_permitted,
            near_ground: check.near_ground,
            beyond_landing_distance: check.beyond_landing_distance,
            said_broken: check.said_broken.len() as u64,
            not_landed: report.not_landed.clone(),
            ended_early: matches!(flight.end.reason, EndReason::Application { cut: true, .. }),
        }
    }

    pub(crate) fn failed(seed: u64, error: &MissionError) -> RunRow {
        RunRow {
            seed,
            outcome: RunOutcome::Error,
            reason: error.to_string(),
            end_s: 0.0,
            score: None,
            benefits: None,
            expected_cost: None,
            fires: None,
            fires_seen: None,
            realised_cost: None,
            expected_cost_stated: None,
            observed: 0,
            left_out: 0,
            reflies: 0,
            plans: 0,
            positions: 0,
            inside_zones: 0,
            outside_permitted: 0,
            near_ground: 0,
            beyond_landing_distance: 0,
            said_broken: 0,
            not_landed: None,
            ended_early: false,
        }
    }

    /// Returns the number of violations: a position counts once for each requirement that is violated there.
    pub fn violations(&self) -> u64 {
        self.inside_zones + self.outside_permitted + self.near_ground + self.beyond_landing_distance
    }
}

/// Flies all flights of a series and returns their rows in the order of their seeds. `done` is called on this thread after each flight;
/// if it returns false, no further flights are started and those in progress are completed.
///
/// The flights share the memory limit of `means` for planners, which therefore grows with the number of threads.
///
/// # Errors
/// The number of flights or threads is out of range, or the mission cannot be simulated at all. A single flight that fails is not an
/// error: its row holds the reason.
pub fn fly_runs(
    mission: &Arc<Mission>,
    means: &PlanningResources,
    terms: &RunTerms,
    mut done: impl FnMut() -> bool,
) -> MissionResult<Vec<RunRow>> {
    in_range("runs", terms.runs, RUNS_MAX)?;
    in_range("jobs", terms.jobs, JOBS_MAX)?;
    let first = terms.first_seed.unwrap_or(mission.settings.seed);
    crate::pace_of(mission, None)?;
    world(mission, Some(first))?;
    let memory_bytes = means.memory_bytes.saturating_mul(terms.jobs as u64);
    let means = PlanningResources { memory_bytes, ..means.clone() };
    let is_stopped = AtomicBool::new(false);
    let task = |number: usize| {
        if is_stopped.load(Ordering::Relaxed) {
            return Ok(None);
        }
        let seed = first.wrapping_add(number as u64);
        let row = fly_one(mission, &means, seed, terms.until).unwrap_or_else(|error| RunRow::failed(seed, &error));
        Ok(Some(row))
    };
    let rows = parallel::each(terms.jobs.min(terms.runs), terms.runs, task, || {
        if !done() {
            is_stopped.store(true, Ordering::Relaxed);
        }
    });
    Ok(rows.map_err(MissionError::flight)?.into_iter().flatten().collect())
}

fn in_range(what: &str, number: usize, most: usize) -> MissionResult<()> {
    if (1..=most).contains(&number) {
        return Ok(());
    }
    Err(MissionError::setting(format!("{number} {what} cannot be flown"))
        .help(format!("write a number from 1 to {most}")))
}

fn fly_one(mission: &Arc<Mission>, means: &PlanningResources, seed: u64, until: Option<Time>) -> MissionResult<RunRow> {
    let mut vehicle = world(mission, Some(seed))?;
    let mut check = FlightCheck::new(mission);
    let (quiet, controls) = mpsc::channel();
    // A mission in real time is flown as fast as possible: no operator takes part in a series.
    quiet.send(Control::Quiet).unwrap_or_default();
    let terms = apex_runtime::RunSettings { controls: Some(controls), ..MissionFlight::terms(mission, until) };
    let mut log = FireLog::default();
    let mut observers: [&mut dyn Observer; 2] = [&mut check, &mut log];
    let flight = MissionFlight::new(Arc::clone(mission), means.clone()).fly(&mut vehicle, terms, &mut observers)?;
    let fires = vehicle.has_ignitions().then(|| log.compare(mission, &flight.report)).flatten();
    Ok(RunRow::flown(seed, &flight, check.result(), fires))
}

/// Summary of a series of flights; printed as text.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunSummary {
    /// Flights flown.
    pub runs: usize,
    /// Number of completed flights.
    pub completed: usize,
    /// Summarised measure: `score` or `expected cost`; empty if neither is known of any flight.
    pub measure: &'static str,
    /// Least value, 5 %, 25 %, median, 75 %, 95 % and greatest value, by nearest rank.
    pub quantiles: Vec<f64>,
    /// Mean of the values.
    pub mean: Option<f64>,
    /// Realised next to expected cost of ignorance; `None` unless fires broke out.
    pub ignorance: Option<IgnoranceSummary>,
    /// Violated requirements by kind.
    pub violations: BTreeMap<&'static str, Violated>,
    /// Flights that were not completed, by reason.
    pub lost: BTreeMap<String, NotCompleted>,
    /// Completed flights that the program ended before the end of their initial task, by reason.
    pub ended_early: BTreeMap<String, NotCompleted>,
    /// Flights after which the vehicle was not on the ground, or crashed: their number and first seed, and the statement about the first.
    pub not_landed: Option<(NotCompleted, String)>,
    /// Flights without an observation of any target.
    pub without_observation: Option<NotCompleted>,
}

/// Flights that violated a requirement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Violated {
    /// Number of these flights.
    pub flights: usize,
    /// Number of positions with the violation in these flights.
    pub positions: u64,
    /// Seed of the first of these flights.
    pub first_seed: u64,
}

/// Flights that ended for the same reason.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct NotCompleted {
    /// Number of these flights.
    pub flights: usize,
    /// Seed of the first of these flights.
    pub first_seed: u64,
}

/// Shares of [`RunSummary::quantiles`].
const SHARES: [f64; 7] = [0.0, 0.05, 0.25, 0.5, 0.75, 0.95, 1.0];

impl RunSummary {
    /// Returns the summary of these flights.
    pub fn of(rows: &[RunRow]) -> RunSummary {
        let scores: Vec<f64> = rows.iter().filter_map(|row| row.score).collect();
        let costs: Vec<f64> = rows.iter().filter_map(|row| row.expected_cost).collect();
        let (measure, mut values) = match (scores.is_empty(), costs.is_empty()) {
            (false, _) => ("score", scores),
            (true, false) => ("expected cost", costs),
            (true, true) => ("", Vec::new()),
        };
        values.sort_by(f64::total_cmp);
        let rank = |share: f64| (share * values.len() as f64).ceil().max(1.0) as usize - 1;
        let mut violations: BTreeMap<&'static str, Violated> = BTreeMap::new();
        let [mut lost, mut early] = [const { BTreeMap::<String, NotCompleted>::new() }; 2];
        for row in rows {
            let kinds = [
                ("inside a restricted zone", row.inside_zones),
                ("outside the permitted area", row.outside_permitted),
                ("near the ground", row.near_ground),
                ("beyond the landing distance", row.beyond_landing_distance),
            ];
            for (kind, positions) in kinds.into_iter().filter(|(_, positions)| *positions > 0) {
                let none = Violated { flights: 0, positions: 0, first_seed: row.seed };
                let found = violations.entry(kind).or_insert(none);
                found.flights += 1;
                found.positions += positions;
            }
            let none = NotCompleted { flights: 0, first_seed: row.seed };
            if row.outcome != RunOutcome::Completed {
                lost.entry(row.reason.clone()).or_insert(none).flights += 1;
            } else if row.ended_early {
                early.entry(row.reason.clone()).or_insert(none).flights += 1;
            }
        }
        let pairs = rows.iter().filter_map(|row| row.realised_cost.zip(row.expected_cost_stated));
        let pairs: Vec<(f64, f64)> = pairs.collect();
        let sum = |of: fn(&RunRow) -> Option<u64>| rows.iter().filter_map(of).sum();
        let first = |is_one: &dyn Fn(&&RunRow) -> bool| {
            let row = rows.iter().find(is_one)?;
            Some((NotCompleted { flights: rows.iter().filter(is_one).count(), first_seed: row.seed }, row))
        };
        let not_landed = first(&|row| row.not_landed.is_some());
        let without_observation =
            first(&|row| row.outcome != RunOutcome::Error && row.observed == 0 && row.left_out > 0);
        RunSummary {
            runs: rows.len(),
            completed: rows.iter().filter(|row| row.outcome == RunOutcome::Completed).count(),
            measure,
            quantiles: SHARES.iter().filter_map(|share| values.get(rank(*share)).copied()).collect(),
            mean: (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64),
            ignorance: IgnoranceSummary::of(&pairs, (sum(|row| row.fires), sum(|row| row.fires_seen))),
            violations,
            lost,
            ended_early: early,
            not_landed: not_landed.map(|(found, row)| (found, row.not_landed.clone().unwrap_or_default())),
            without_observation: without_observation.map(|(found, _)| found),
        }
    }
}

impl fmt::Display for RunSummary {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(out, "{} flights, {} completed", self.runs, self.completed)?;
        if let (Some(mean), [least, five, quarter, median, three, most, greatest]) = (self.mean, &*self.quantiles) {
            writeln!(
                out,
                "{}: least {least:.1}, 5 % {five:.1}, 25 % {quarter:.1}, median {median:.1}, 75 % {three:.1}, \
                 95 % {most:.1}, greatest {greatest:.1}, mean {mean:.1}",
                if self.measure == "score" { "Score" } else { "Expected cost" }
            )?;
        }
        if let Some(ignorance) = &self.ignorance {
            writeln!(
                out,
                "Ignorance: {} fires in {} flights, {} seen; a flight cost {:.2}, expected {:.2} (standard error {:.2}, \
                 {:+.1} of them)",
                ignorance.fires,
                ignorance.flights,
                ignorance.seen,
                ignorance.realised,
                ignorance.expected,
                ignorance.standard_error,
                ignorance.deviation()
            )?;
        }
        for (kind, Violated { flights, positions, first_seed: seed }) in &self.violations {
            writeln!(out, "Violated: {kind}: {positions} positions in {flights} flights; --seed {seed} is the first")?;
        }
        if self.violations.is_empty() {
            writeln!(out, "Violated: no requirement in any position checked")?;
        }
        for (reason, NotCompleted { flights, first_seed: seed }) in &self.lost {
            writeln!(out, "Not completed: {flights} because {reason}; --seed {seed} is the first")?;
        }
        for (reason, NotCompleted { flights, first_seed: seed }) in &self.ended_early {
            writeln!(out, "Ended early: {flights} because {reason}; --seed {seed} is the first")?;
        }
        if let Some((NotCompleted { flights, first_seed: seed }, statement)) = &self.not_landed {
            writeln!(out, "Not landed: {flights}; --seed {seed} is the first: {statement}")?;
        }
        if let Some(NotCompleted { flights, first_seed: seed }) = &self.without_observation {
            writeln!(out, "Without an observation: {flights}; --seed {seed} is the first")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(seed: u64, score: f64, outcome: RunOutcome) -> RunRow {
        let error = MissionError::flight("the task failed");
        RunRow { score: Some(score), outcome, ..RunRow::failed(seed, &error) }
    }

    #[test]
    fn quantiles_are_of_nearest_rank() {
        let rows: Vec<RunRow> = (1..=20).map(|seed| row(seed, seed as f64, RunOutcome::Completed)).collect();
        let summary = RunSummary::of(&rows);
        assert_eq!(summary.quantiles, [1.0, 1.0, 5.0, 10.0, 15.0, 19.0, 20.0]);
        assert_eq!((summary.mean, summary.completed), (Some(10.5), 20));
        assert_eq!(RunSummary::of(&rows[..1]).quantiles, [1.0; 7]);
        assert_eq!(RunSummary::of(&[]).quantiles, [] as [f64; 0]);
    }

    #[test]
    fn losses_and_violations_name_the_first_seed() {
        let mut rows =
            vec![row(7, 1.0, RunOutcome::Completed), row(8, 0.0, RunOutcome::Lost), row(9, 0.0, RunOutcome::Lost)];
        (rows[1].inside_zones, rows[2].inside_zones) = (3, 4);
        rows.iter_mut().for_each(|row| row.left_out = 1);
        let text = RunSummary::of(&rows).to_string();
        assert!(
            text.contains("Violated: inside a restricted zone: 7 positions in 2 flights; --seed 8 is the first"),
            "{text}"
        );
        assert!(text.contains("Not completed: 2 because") && text.contains("--seed 8 is the first"), "{text}");
        assert!(RunSummary::of(&rows[..1]).to_string().contains("Violated: no requirement"));
        assert!(text.contains("Without an observation: 3; --seed 7 is the first"), "{text}");
        (rows[0].ended_early, rows[0].reason) = (true, "it landed".to_string());
        let early = RunSummary::of(&rows).to_string();
        assert!(early.contains("Ended early: 1 because it landed; --seed 7 is the first"), "{early}");
        rows[1].not_landed = Some("the vehicle crashed".to_string());
        rows.iter_mut().for_each(|row| row.observed = 1);
        let text = RunSummary::of(&rows).to_string();
        assert!(text.contains("Not landed: 1; --seed 8 is the first: the vehicle crashed"), "{text}");
        assert!(!text.contains("Without an observation"), "{text}");
    }
}
