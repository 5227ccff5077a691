//! What a flight achieved, for people and as JSON: score by factor, visits, what was left out and why, decisions of note.

use super::bookkeeping::{Bookkeeping, Note, Visit};
use super::problem::pose;
use super::{Mission, Target, TargetKind};
use apex_geo::coverage::LineScanner;
use apex_metrics::eci::{ExpectedCost, expected_cost};
use apex_metrics::mission_score::{MissionScore, Observation, crew_hours, mission_score};
use apex_model::problem::{Problem, QualityFactor, QualityFactors, SurveillanceVisit};
use apex_model::time::Time;
use apex_runtime::record::TargetState;

/// The report of one flight.
pub struct Report {
    /// The mission's title.
    pub mission: String,
    /// When and why it ended.
    pub end: (Time, String),
    /// Observations in order.
    pub visits: Vec<Visit>,
    /// Targets never observed, with the last reason given.
    pub left_out: Vec<(String, String)>,
    /// The value that the mission is measured by.
    pub value: MissionValue,
    /// Decisions of note.
    pub notes: Vec<Note>,
}

/// What a mission is measured by.
pub enum MissionValue {
    /// Single visits: the mission score.
    Score(MissionScore),
    /// Surveillance: the expected cost of ignorance.
    Ignorance(ExpectedCost),
    /// Neither.
    None,
}

/// Makes the report. `changes` are all changes of targets' states in order.
pub fn report(
    mission: &Mission,
    books: &Bookkeeping,
    changes: &[(String, Time, TargetState, String)],
    end: (Time, String),
) -> Report {
    let left_out = mission
        .targets
        .iter()
        .filter(|target| matches!(target.kind, TargetKind::Fire(_) | TargetKind::Site(_)))
        .filter(|target| !books.observed().any(|visit| visit.target == target.id))
        .map(|target| (target.id.clone(), reason_left_out(target, books, changes)))
        .collect();
    Report {
        mission: mission.settings.name.clone(),
        value: value(mission, books, end.0),
        end,
        visits: books.visits.clone(),
        left_out,
        notes: books.notes.clone(),
    }
}

fn reason_left_out(target: &Target, books: &Bookkeeping, changes: &[(String, Time, TargetState, String)]) -> String {
    if target.announced_late && !books.news.is_announced(&target.id) {
        return "never announced".to_string();
    }
    match changes.iter().rev().find(|(id, ..)| *id == target.id) {
        Some((_, _, TargetState::Skipped, detail)) => detail.clone(),
        Some((_, _, TargetState::Planned, detail)) => format!("{detail}, but the flight ended before"),
        Some((_, at, TargetState::Observing, _)) => format!("begun at {at} and broken off"),
        Some((_, at, TargetState::Observed, _)) => format!("observed at {at}"),
        None => "no plan ever reached it".to_string(),
    }
}

fn value(mission: &Mission, books: &Bookkeeping, end: Time) -> MissionValue {
    if mission.targets.iter().any(|target| matches!(target.kind, TargetKind::Fire(_))) {
        let mission = &books.news.valued(mission);
        let observations: Vec<Observation> = books.observed().filter_map(|visit| observation(mission, visit)).collect();
        let hours = end.seconds() / 3600.0;
        let crew = crew_hours(&mission.crew, hours);
        return MissionValue::Score(mission_score(&observations, &crew, &mission.failure, hours));
    }
    let mission = &books.news.believed(mission);
    let Ok(Problem::Surveillance(problem)) = pose(mission, &Bookkeeping::default(), Time::ZERO) else {
        return MissionValue::None;
    };
    if problem.targets.is_empty() {
        return MissionValue::None;
    }
    let flown = |visit: &Visit| {
        let end_s = visit.end?.seconds();
        Some(SurveillanceVisit { target: visit.target.clone(), arrive_s: visit.begin.seconds(), end_s })
    };
    let visits: Vec<SurveillanceVisit> = books.observed().filter_map(flown).collect();
    MissionValue::Ignorance(expected_cost(&problem, &visits))
}

/// Coverage, resolution, clarity and timing as flown.
fn observation(mission: &Mission, visit: &Visit) -> Option<Observation> {
    let target = mission.targets.iter().find(|target| target.id == visit.target)?;
    let TargetKind::Fire(fire) = &target.kind else { return None };
    let count = |(all, seen, level): (usize, usize, usize), line: &super::lines::ScanLine| {
        let (more, more_seen, more_level) = line.count();
        (all + more, seen + more_seen, level + more_level)
    };
    let (all, seen, level) = visit.lines.iter().fold((0, 0, 0), count);
    let share = |part: usize, whole: usize| if whole == 0 { 0.0 } else { part as f64 / whole as f64 };
    let coverage = (share(seen, all) / fire.share).min(1.0);
    let clarity = share(level, seen);
    let height_m = visit.altitude_m().unwrap_or(target.elevation_m) - target.elevation_m;
    let obtained_m = LineScanner::FIRE.resolution_m(height_m.max(0.0));
    let resolution = if obtained_m > 0.0 { (fire.resolution_m / obtained_m).min(1.0) } else { 0.0 };
    Some(Observation {
        target: target.name.clone(),
        value: fire.value,
        quality: QualityFactors {
            coverage: factor(coverage, format!("{:.0} % of the lines seen", 100.0 * share(seen, all))),
            resolution: factor(
                resolution,
                format!(
                    "{obtained_m:.1} m per pixel from {height_m:.0} m above ground, {:.1} m wanted",
                    fire.resolution_m
                ),
            ),
            clarity: factor(
                clarity,
                format!("{} of {seen} pieces with a wing low, up to {:.0} deg", seen - level, visit.roll_deg_max),
            ),
        },
        timing: timing(target, visit),
    })
}

fn timing(target: &Target, visit: &Visit) -> QualityFactor {
    let TargetKind::Fire(fire) = &target.kind else { return QualityFactor::default() };
    let begin_s = visit.begin.seconds();
    if fire.windows.is_empty() || fire.windows.iter().any(|window| window.contains(begin_s)) {
        return QualityFactor::default();
    }
    factor(0.0, format!("began at {}, outside of its windows", visit.begin))
}

fn factor(value: f64, cause: String) -> QualityFactor {
    QualityFactor { factor: value, cause: if value >= 1.0 { String::new() } else { cause } }
}
