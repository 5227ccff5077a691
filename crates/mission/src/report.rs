//! What a flight achieved, for people and as JSON: score by factor, visits, what was left out and why, decisions of note.

use super::problem::pose;
use super::situation::{Note, Situation, Visit};
use super::vehicle::line_scanner;
use super::{Mission, Target, TargetKind};
use apex_metrics::eci::{ExpectedCost, expected_cost};
use apex_metrics::mission_score::{MissionScore, Observation, crew_hours, mission_score};
use apex_model::problem::{Problem, QualityFactor, QualityFactors, SurveillanceVisit};
use apex_model::time::Time;
use apex_runtime::target_state::{TargetChange, TargetState};

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
    /// Number of plans that were adopted.
    pub plans: u32,
    /// Ids of the targets with their names.
    pub names: Vec<(String, String)>,
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

/// Makes the report of a flight that ended in this situation, at this time and for this reason.
pub fn report(mission: &Mission, situation: &Situation, end: (Time, String)) -> Report {
    let left_out = mission
        .targets
        .iter()
        .filter(|target| matches!(target.kind, TargetKind::Fire(_) | TargetKind::Site(_)))
        .filter(|target| !situation.observed().any(|visit| visit.target == target.id))
        .map(|target| (target.id.clone(), reason_left_out(target, situation)))
        .collect();
    Report {
        mission: mission.settings.name.clone(),
        value: value(mission, situation, end.0),
        end,
        visits: situation.visits.clone(),
        left_out,
        notes: situation.notes.clone(),
        plans: situation.adopted,
        names: mission.targets.iter().map(|target| (target.id.clone(), target.name.clone())).collect(),
    }
}

fn reason_left_out(target: &Target, situation: &Situation) -> String {
    if target.announced_late && !situation.updates.is_announced(&target.id) {
        return "never announced".to_string();
    }
    let last = situation.target_changes.iter().rev().find(|change| change.target == target.id);
    let Some(TargetChange { at, state, detail, .. }) = last else { return "no plan ever reached it".to_string() };
    match state {
        TargetState::Skipped => detail.clone(),
        TargetState::Planned => format!("{detail}, but the flight ended before"),
        TargetState::Observing => format!("begun at {at} and broken off"),
        TargetState::Observed => format!("observed at {at}"),
    }
}

fn value(mission: &Mission, situation: &Situation, end: Time) -> MissionValue {
    if mission.targets.iter().any(|target| matches!(target.kind, TargetKind::Fire(_))) {
        let mission = &situation.updates.valued(mission);
        let observations: Vec<Observation> =
            situation.observed().filter_map(|visit| observation(mission, visit)).collect();
        let hours = end.seconds() / 3600.0;
        let crew = crew_hours(&mission.crew, hours);
        return MissionValue::Score(mission_score(&observations, &crew, &mission.failure, hours));
    }
    let mission = &situation.updates.believed(mission);
    let Ok(Problem::Surveillance(problem)) = pose(mission, &Situation::default(), Time::ZERO) else {
        return MissionValue::None;
    };
    if problem.targets.is_empty() {
        return MissionValue::None;
    }
    let flown = |visit: &Visit| {
        let end_s = visit.end?.seconds();
        Some(SurveillanceVisit { target: visit.target.clone(), arrive_s: visit.begin.seconds(), end_s })
    };
    let visits: Vec<SurveillanceVisit> = situation.observed().filter_map(flown).collect();
    MissionValue::Ignorance(expected_cost(&problem, &visits))
}

/// Coverage, resolution, clarity and timing as flown.
fn observation(mission: &Mission, visit: &Visit) -> Option<Observation> {
    let target = mission.targets.iter().find(|target| target.id == visit.target)?;
    let TargetKind::Fire(fire) = &target.kind else { return None };
    let count = |(all, seen, level): (usize, usize, usize), line: &super::situation::ScanLine| {
        let (more, more_seen, more_level) = line.count();
        (all + more, seen + more_seen, level + more_level)
    };
    let (all, seen, level) = visit.lines.iter().fold((0, 0, 0), count);
    let share = |part: usize, whole: usize| if whole == 0 { 0.0 } else { part as f64 / whole as f64 };
    let coverage = (share(seen, all) / fire.share).min(1.0);
    let clarity = share(level, seen);
    let height_m = visit.altitude_m().unwrap_or(target.elevation_m) - target.elevation_m;
    let obtained_m = line_scanner(&mission.model).map_or(0.0, |scanner| scanner.resolution_m(height_m.max(0.0)));
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
