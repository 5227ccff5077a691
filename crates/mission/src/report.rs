//! Report of a flight, as text and as JSON: score by factor, visits, targets left out with reasons, notable decisions.

use super::problem::{trouble, watched};
use super::score::{FlightScore, FlownScore, flight_score, is_complete};
use super::situation::{NoPlanReason, Note, Situation, Visit};
use super::{Mission, Target, TargetKind};
use crate::observing::looks_with;
use apex_metrics::eci::{ExpectedCost, expected_cost};
use apex_model::problem::SurveillanceVisit;
use apex_model::time::Time;
use apex_observation::result::LookResult;
use apex_runtime::target_state::{TargetChange, TargetState};
use std::collections::BTreeSet;

/// The report of one flight.
pub struct Report {
    /// The mission's title.
    pub mission: String,
    /// Instant and reason of its end.
    pub end: (Time, String),
    /// Reason for which the initial task failed; `None` if it did not, and while the flight continues.
    pub failed_because: Option<String>,
    /// Statement about a vehicle that did not land; `None` if it is on the ground, and while the flight continues.
    pub not_landed: Option<String>,
    /// A statement about a vehicle on the ground away from every landing place; `None` for another one.
    pub landed_away: Option<String>,
    /// Observations in order.
    pub visits: Vec<Visit>,
    /// Number of visits that ended, and of targets that were observed without a visit, by pictures alone.
    pub observed: usize,
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

/// Measure of a mission.
pub enum MissionValue {
    /// Single visits: the mission score.
    Score(FlightScore),
    /// Surveillance: the expected cost of ignorance.
    Ignorance(ExpectedCost, Vec<SiteLooks>),
    /// Neither.
    None,
}

/// Pictures of a site by the camera.
#[derive(Clone, Debug, PartialEq)]
pub struct SiteLooks {
    /// The site's id.
    pub target: String,
    /// Visits that ended.
    pub visits: usize,
    /// Number of visits with a valid picture: only these count as observations.
    pub seen: usize,
    /// Mean pixel size on the ground of the pictures that count, m; `None` without one.
    pub pixel_m: Option<f64>,
    /// Their mean angle off the vertical, degrees.
    pub look_angle_deg: Option<f64>,
    /// Coverage, clarity and resolution of the best picture, 0 to 1.
    pub quality: f64,
    /// Greatest cause of its losses; `None` without losses or pictures.
    pub lost: Option<&'static str>,
}

/// Returns the report of a flight that ended in this situation, at this time and for this reason; `flown` are its observations, or the
/// reason for which they are unknown.
pub fn report(
    mission: &Mission,
    situation: &Situation,
    flown: Result<&FlownScore, &str>,
    end: (Time, String),
) -> Report {
    let grown = flown.ok().map(|flown| flown.with_growth(mission.clone()));
    let left_out = grown
        .as_ref()
        .unwrap_or(mission)
        .targets
        .iter()
        .flat_map(|target| names_of(target).into_iter().map(move |name| (target, name)))
        .filter(|(_, name)| !situation.observed().any(|visit| visit.target == *name))
        .map(|(target, name)| {
            let begun = |change: &TargetChange| change.target == name && change.state == TargetState::Observing;
            let why = match (is_seen_completely(target, &name, flown), situation.target_changes.iter().any(begun)) {
                (true, true) => "seen completely, although its observation was not completed".to_string(),
                (true, false) => "seen completely in passing, without an observation of it".to_string(),
                (false, _) => {
                    let why = reason_left_out(mission, target, &name, situation);
                    match result_of(target, &name, flown).map(|seen| seen.factors.coverage) {
                        Some(coverage) if coverage >= COVERAGE_STATED => {
                            format!("seen in part (coverage {coverage:.2}); {why}")
                        }
                        _ => why,
                    }
                }
            };
            (name, why)
        })
        .collect();
    let ending = situation.ending();
    let not_landed = ending.not_landed(mission, (&situation.vehicle, situation.wind_mps()), end.0);
    Report {
        mission: mission.settings.name.clone(),
        value: value(mission, situation, flown, end.0),
        end,
        failed_because: ending.failed_because().map(str::to_string),
        not_landed,
        landed_away: ending.landed_away(mission, situation.vehicle.position),
        visits: situation.visits.clone(),
        observed: observed(situation),
        left_out,
        notes: notes(situation),
        plans: situation.adopted,
        names: mission.targets.iter().map(|target| (target.id.clone(), target.name.clone())).collect(),
    }
}

/// Returns the number of visits that ended, and of targets that were observed without one: several messages may state the same picture.
fn observed(situation: &Situation) -> usize {
    let ended = || situation.visits.iter().filter(|visit| visit.end.is_some());
    let changes = situation.target_changes.iter().filter(|change| change.state == TargetState::Observed);
    let without_visit = changes.filter(|change| ended().all(|visit| visit.target != change.target));
    ended().count() + without_visit.map(|change| change.target.as_str()).collect::<BTreeSet<_>>().len()
}

/// Returns the notes of the flight, with one about a plan that no task flew.
fn notes(situation: &Situation) -> Vec<Note> {
    let mut notes = situation.notes.clone();
    if let Some((at, why)) = situation.ending().idle_plan() {
        let place = notes.partition_point(|note| note.at <= at);
        notes.insert(place, Note { at, text: format!("this plan was not flown: {why}") });
    }
    notes
}

/// Returns the names of the observations of a target in plans: the target's name, or one for each wanted look.
fn names_of(target: &Target) -> Vec<String> {
    match &target.kind {
        TargetKind::Fire(fire) => fire.looks().map(|(name, _)| name).collect(),
        TargetKind::Site(_) => vec![target.id.clone()],
        TargetKind::Plain | TargetKind::Base => Vec::new(),
    }
}

/// Least coverage that the reason of a target without an observation states.
const COVERAGE_STATED: f64 = 0.01;

/// Returns true if a look that no visit observed was nevertheless seen completely.
fn is_seen_completely(target: &Target, name: &str, flown: Result<&FlownScore, &str>) -> bool {
    result_of(target, name, flown).is_some_and(|seen| is_complete(&seen))
}

/// Returns the scored result of a look; `None` for sites, and if the score is unknown.
fn result_of(target: &Target, name: &str, flown: Result<&FlownScore, &str>) -> Option<LookResult> {
    let (TargetKind::Fire(fire), Ok(flown)) = (&target.kind, flown) else { return None };
    let (_, look) = fire.looks().find(|(of_look, _)| of_look == name)?;
    flown.result(&target.id)?.looks.into_iter().find(|seen| seen.name == look.name)
}

fn reason_left_out(mission: &Mission, target: &Target, name: &str, situation: &Situation) -> String {
    if target.announced_late && !situation.updates.is_announced(&target.id) {
        return "never announced".to_string();
    }
    let last = situation.target_changes.iter().rev().find(|change| change.target == name);
    let Some(TargetChange { at, state, detail, .. }) = last else {
        return match trouble(mission, target, name) {
            Some(why) => format!("no way to observe it: {why}"),
            None => match situation.ending().no_plan().filter(|_| situation.plan.is_none()) {
                Some(NoPlanReason::Failed(reason)) => format!("there was no plan: {reason}"),
                Some(NoPlanReason::WithoutVisits(summary)) => summary.clone(),
                Some(NoPlanReason::NotAcquired { target, why }) if target == name => why.clone(),
                Some(NoPlanReason::NotAcquired { .. }) => "no plan included it".to_string(),
                None => "no plan included it".to_string(),
            },
        };
    };
    match state {
        TargetState::Skipped => detail.clone(),
        TargetState::Planned if let Some((_, why)) = situation.ending().idle_plan().filter(|idle| idle.0 <= *at) => {
            format!("planned {detail}, but {why}")
        }
        TargetState::Planned => format!("planned {detail}, but the flight ended before"),
        TargetState::Observing => format!("begun at {at} and interrupted"),
        TargetState::Observed => format!("observed at {at}"),
    }
}

fn value(mission: &Mission, situation: &Situation, flown: Result<&FlownScore, &str>, end: Time) -> MissionValue {
    if mission.targets.iter().any(|target| matches!(target.kind, TargetKind::Fire(_))) {
        let valued = situation.updates.valued(mission);
        let mission = &match flown {
            Ok(flown) => flown.with_growth(valued),
            Err(_) => valued,
        };
        return MissionValue::Score(flight_score(mission, situation, flown, end.seconds() / 3600.0));
    }
    let mission = &situation.updates.believed(mission);
    let Ok(problem) = watched(mission) else { return MissionValue::None };
    if problem.targets.is_empty() {
        return MissionValue::None;
    }
    // With a camera, a visit without a valid picture has seen nothing.
    let score = flown.ok().filter(|_| looks_with(&mission.model).is_some());
    let is_seen = |visit: &Visit| {
        let end_s = visit.end.map(Time::seconds);
        let site = mission.targets.iter().find(|target| target.id == visit.target);
        // A vehicle whose sensors cannot see a site from its visits has seen nothing either.
        let is_in_sight = || site.is_none_or(|site| trouble(mission, site, &site.id).is_none());
        let saw = |score: &FlownScore, end_s| score.saw(&visit.target, visit.begin.seconds(), end_s);
        end_s.is_some_and(|end_s| score.map_or_else(is_in_sight, |score| saw(score, end_s)))
    };
    let flown = |visit: &Visit| {
        let end_s = visit.end?.seconds();
        Some(SurveillanceVisit { target: visit.target.clone(), arrive_s: visit.begin.seconds(), end_s })
    };
    let visits: Vec<SurveillanceVisit> =
        situation.observed().filter(|visit| is_seen(visit)).filter_map(flown).collect();
    let results = score.map(FlownScore::results).unwrap_or_default();
    let looks = results.into_iter().filter_map(|result| {
        let best = result.looks.into_iter().next()?;
        let of_site = || situation.observed().filter(|visit| visit.target == result.name);
        Some(SiteLooks {
            visits: of_site().count(),
            seen: of_site().filter(|visit| is_seen(visit)).count(),
            pixel_m: best.seen.pixel_m_mean,
            look_angle_deg: best.seen.look_angle_deg_mean,
            quality: best.factors.product(),
            lost: greatest_loss(&best),
            target: result.name,
        })
    });
    MissionValue::Ignorance(expected_cost(&problem, &visits), looks.collect())
}

/// Returns the words of the cause that costs most; `None` if nothing was lost.
fn greatest_loss(look: &LookResult) -> Option<&'static str> {
    let losses = look.losses.iter().filter(|loss| loss.points > 0.0);
    losses.max_by(|a, b| a.points.total_cmp(&b.points)).map(|loss| loss.cause.words())
}
