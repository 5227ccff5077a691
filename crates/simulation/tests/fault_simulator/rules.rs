//! The rules that a flight must keep.
//!
//! A failure is not an excuse merely because it occurred at some time: it must explain the event at the time of the event.

use crate::story::{FaultSpan, Story};
use apex_mission::verification::{CheckResult, Finding, ReportedViolation, Violation};
use apex_runtime::{EndReason, RunEnd};

/// Greatest time between the announcement of a violation and its beginning: the look-ahead of the watcher, and the time for a response.
const ANNOUNCED_S_MAX: f64 = 900.0;
/// The same for a way through a zone, which is announced when the way is selected.
const CHOSEN_S_MAX: f64 = 7_200.0;
/// Violations of one requirement that are at most this far apart count as one.
const EPISODE_GAP_S: f64 = 60.0;
/// False positions have effects for this long: the jump back, and the way selected by them.
const FALSE_POSITION_S: f64 = 120.0;
/// A report that explains the end of a flight, or its loss, came at most this long before.
const EXPLAINED_S_MAX: f64 = 3_600.0;

/// Returns the rules that a flight with guards broke.
pub(crate) fn broken(story: &Story, end: &RunEnd, check: &CheckResult) -> Vec<String> {
    let mut rules = kept_by_all(story, end, check);
    rules.extend(end_explained(story, end));
    rules.extend(loss_reported(story));
    rules.extend(episodes(check).iter().filter_map(|episode| unannounced(story, check, episode)));
    rules
}

/// Returns the violated rules among those for every flight, with or without guards.
pub(crate) fn kept_by_all(story: &Story, end: &RunEnd, _check: &CheckResult) -> Vec<String> {
    let mut rules = Vec::new();
    if let Some(first) = story.asker.missing().first() {
        rules.push(format!("a task is silent: {first} ({} in all)", story.asker.missing().len()));
    }
    if matches!(end.reason, EndReason::Quiescent | EndReason::Stopped) {
        rules.push(format!("it ended as {}", end.reason.text()));
    }
    rules.extend(loss_explained(story));
    rules
}

/// Returns violations of two rules: an application that ends leaves no vehicle in the air, and a failed initial task has a reported
/// reason.
fn end_explained(story: &Story, end: &RunEnd) -> Vec<String> {
    let EndReason::Application { reason, failed, .. } = &end.reason else { return Vec::new() };
    let end_s = end.at.seconds();
    let mut rules = Vec::new();
    if story.airborne {
        rules.push(format!("at {end_s:.0} s it ended in the air: {reason}"));
    }
    let reported = story.reported.iter().any(|(at_s, _)| *at_s <= end_s && end_s - at_s <= EXPLAINED_S_MAX);
    if *failed && !reported {
        rules.push(format!("at {end_s:.0} s, without a report before: {reason}"));
    }
    rules
}

/// Returns a violation if the vehicle was lost, and no report came before.
fn loss_reported(story: &Story) -> Option<String> {
    let lost_s = story.lost_s?;
    let reported = story.reported.iter().any(|(at_s, _)| *at_s <= lost_s && lost_s - at_s <= EXPLAINED_S_MAX);
    (!reported).then(|| format!("at {lost_s:.0} s it was lost, and no task reported it before: {:?}", story.faults))
}

/// Returns a violation if the vehicle was lost without a known cause.
fn loss_explained(story: &Story) -> Option<String> {
    let lost_s = story.lost_s?;
    // Without engine or energy a landing may fail; with wrong readings, or without acknowledgements, a flight may meet the ground.
    let can_lose = |span: &FaultSpan| match span.kind.as_str() {
        "engine" | "leak" | "navigation" | "acknowledgements" => true,
        "freeze" | "silence" | "bias" => {
            ["altitude", "location", "fuel", "battery-charge", "true-airspeed", "ground-speed"]
                .contains(&span.of.as_str())
        }
        _ => false,
    };
    let mut causes =
        story.faults.iter().filter(|span| span.from_s <= lost_s && lost_s - span.until_s <= EXPLAINED_S_MAX);
    let is_explained = causes.any(can_lose);
    (!is_explained)
        .then(|| format!("at {lost_s:.0} s it was lost without a failure that can cause it: {:?}", story.faults))
}

/// Returns the first of each group of consecutive violations of one requirement.
fn episodes(check: &CheckResult) -> Vec<&Finding> {
    let mut begins: Vec<&Finding> = Vec::new();
    let mut last: Vec<(&Violation, f64)> = Vec::new();
    for finding in &check.findings {
        match last.iter_mut().find(|(violation, _)| **violation == finding.violation) {
            Some((_, at_s)) if finding.t_s - *at_s <= EPISODE_GAP_S => *at_s = finding.t_s,
            Some((_, at_s)) => {
                *at_s = finding.t_s;
                begins.push(finding);
            }
            None => {
                last.push((&finding.violation, finding.t_s));
                begins.push(finding);
            }
        }
    }
    begins
}

/// Returns a violation that no message announced before it began, and that no failure explains.
fn unannounced(story: &Story, check: &CheckResult, episode: &Finding) -> Option<String> {
    let begin_s = episode.t_s;
    let before = |at_s: f64, most_s: f64| at_s <= begin_s && begin_s - at_s <= most_s;
    let (requirement, zone) = match &episode.violation {
        Violation::Inside(zone) => ("airspace", Some(zone.as_str())),
        Violation::OutsidePermitted => ("airspace", None),
        Violation::NearGround | Violation::Crashed => ("terrain", None),
        Violation::BeyondLandingDistance => ("landing-distance", None),
    };
    let named = |text: &str| {
        let words = format!("(responding {requirement} ");
        let failed = format!("(response-failed {requirement} ");
        (text.starts_with(&words) && zone.is_none_or(|zone| text.contains(zone))) || text.starts_with(&failed)
    };
    let announced = story.reported.iter().any(|(at_s, text)| before(*at_s, ANNOUNCED_S_MAX) && named(text));
    let is_chosen = |said: &ReportedViolation| before(said.t_s, CHOSEN_S_MAX) && said.is_about(&episode.violation);
    let chosen = check.said_broken.iter().any(is_chosen);
    // Checks with false positions prove nothing, and a glide cannot choose its way.
    let is_false = story.faults.iter().any(|span| {
        let concerns = span.kind == "navigation"
            || (["freeze", "silence"].contains(&span.kind.as_str())
                && ["location", "altitude"].contains(&span.of.as_str()));
        concerns && span.from_s <= begin_s && begin_s <= span.until_s + FALSE_POSITION_S
    });
    let glides =
        story.faults.iter().any(|span| span.kind == "engine" && (span.from_s..=span.until_s).contains(&begin_s))
            && story.reported.iter().any(|(at_s, text)| before(*at_s, CHOSEN_S_MAX) && text.starts_with("(engine-out"));
    (!announced && !chosen && !is_false && !glides).then(|| {
        let all = story
            .reported
            .iter()
            .filter(|(at_s, _)| before(*at_s, CHOSEN_S_MAX))
            .map(|(at_s, text)| format!("{at_s:.0} {text}"));
        let last: Vec<String> = all.collect::<Vec<_>>().into_iter().rev().take(3).collect();
        format!(
            "at {begin_s:.0} s {:?} was not announced; last said {last:?}; faults {:?}",
            episode.violation, story.faults
        )
    })
}
