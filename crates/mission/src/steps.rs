//! A plan's steps: what the executive flies of it, as a procedure of PDL.

use super::deliberator::Deliberation;
use super::problem::{survey, visit_altitude_m};
use super::{Mission, Target, TargetKind, people};
use crate::vehicle::Airframe;
use apex_model::event::PlannedProcedure;
use apex_model::expression::Template;
use apex_model::problem::{Manoeuvre, Plan, Position, Problem, SingleVisitPlan, SingleVisitProblem, SurveillancePlan};
use apex_model::source::SourceFile;
use apex_model::symbol::Symbol;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;

/// The plan as a procedure for `goal`.
pub fn translate(solved: &Deliberation, goal: &Value, number: u32, mission: &Mission) -> PlannedProcedure {
    let (mut steps, repeat) = match (&solved.problem, &solved.plan) {
        (Problem::SingleVisit(problem), Plan::SingleVisit(plan)) => (single_visit_steps(problem, plan), false),
        (_, Plan::Surveillance(plan)) => surveillance_steps(plan, mission, solved.from),
        (Problem::Surveillance(_), Plan::SingleVisit(_)) => (Vec::new(), false),
    };
    if solved.people_plan_better {
        steps.insert(0, people::step(goal, solved.plan.summary()));
    }
    let name = format!("<plan {number}>");
    let procedure = apex_pdl::print_plan(goal, &steps, repeat);
    let text = format!("; {}\n; {}\n{procedure}", solved.plan.summary(), solved.reason);
    PlannedProcedure {
        solver: Symbol::new(solved.plan.solver()),
        summary: solved.plan.summary().to_string(),
        steps: steps.into_iter().map(|(tag, step)| (tag, Template::Constant(step))).collect(),
        repeat,
        source: SourceFile { name: name.into(), text: text.into() },
    }
}

/// The plan of a mission in progress for which nothing more can be planned: it ends, and the way back begins.
pub(super) fn nothing_more(goal: &Value, number: u32, reason: &str) -> PlannedProcedure {
    let summary = format!("nothing more to visit. {reason}");
    let text = format!("; {summary}\n{}", apex_pdl::print_plan(goal, &[], false));
    PlannedProcedure {
        solver: Symbol::new("single-visit"),
        summary,
        steps: Vec::new(),
        repeat: false,
        source: SourceFile { name: format!("<plan {number}>").into(), text: text.into() },
    }
}

fn single_visit_steps(problem: &SingleVisitProblem, plan: &SingleVisitPlan) -> Vec<(Symbol, Value)> {
    let mut steps = Vec::new();
    let mut altitude_m = problem.vehicle.cruise_altitude_m;
    let mut ready_s = problem.start_s;
    for visit in &plan.visits {
        let target = problem.targets.iter().find(|target| target.name == visit.target);
        let Some(manoeuvre) = target.and_then(|target| target.manoeuvres.get(visit.manoeuvre)) else { continue };
        hold(&mut steps, &visit.route, altitude_m, visit.depart_s - ready_s);
        ready_s = visit.end_s;
        detour(&mut steps, &visit.route, altitude_m);
        altitude_m = manoeuvre.altitude_m;
        let form = Value::list([
            Value::symbol("observe"),
            Value::symbol(&visit.target),
            Value::symbol("along"),
            observed_lines(manoeuvre),
            Value::symbol("due"),
            Value::Duration(Duration::from_seconds(visit.end_s.round())),
        ]);
        steps.push((Symbol::new(&format!("observe-{}", visit.target)), form));
    }
    hold(&mut steps, &plan.return_route, altitude_m, plan.return_depart_s - ready_s);
    detour(&mut steps, &plan.return_route, altitude_m);
    steps
}

/// The lines that an observation flies, as its step says them.
pub(super) fn observed_lines(manoeuvre: &Manoeuvre) -> Value {
    let place = |position: &Position| at(*position, manoeuvre.altitude_m);
    Value::list(manoeuvre.lines.iter().map(|(from, to)| Value::list([place(from), place(to)])))
}

/// Staying where a route begins until it is open; nothing for less than a second.
fn hold(steps: &mut Vec<(Symbol, Value)>, route: &[Position], altitude_m: f64, seconds: f64) {
    let Some(here) = route.first().filter(|_| seconds >= 1.0) else { return };
    let tag = Symbol::new(&format!("hold-{}", steps.len() + 1));
    let time = Value::Duration(Duration::from_seconds(seconds.round()));
    let words = [Value::symbol("loiter"), Value::symbol("at"), at(*here, altitude_m), Value::symbol("for"), time];
    steps.push((tag, Value::list(words)));
}

/// Way points strictly between the ends of a route: the bends around airspace.
fn detour(steps: &mut Vec<(Symbol, Value)>, route: &[Position], altitude_m: f64) {
    let bends = route.len().saturating_sub(2);
    for bend in route.iter().skip(1).take(bends) {
        let tag = Symbol::new(&format!("around-{}", steps.len() + 1));
        steps.push((tag, Value::list([Value::symbol("fly"), Value::symbol("to"), at(*bend, altitude_m)])));
    }
}

fn surveillance_steps(
    plan: &SurveillancePlan,
    mission: &Mission,
    from: Option<(Position, Time)>,
) -> (Vec<(Symbol, Value)>, bool) {
    let repeat = !plan.cycle.is_empty();
    let order: Vec<&String> =
        if repeat { plan.cycle.iter().collect() } else { plan.visits.iter().map(|visit| &visit.target).collect() };
    let site = |target: &Target| match &target.kind {
        TargetKind::Site(site) => Some((target.clone(), site.dwell_s)),
        _ => None,
    };
    let sites: Vec<(Target, f64)> = mission.targets.iter().filter_map(site).collect();
    let positions: Vec<Position> = sites.iter().map(|(target, _)| target.position).collect();
    let (start, begin) = from.unwrap_or((mission.start, Time::ZERO));
    let mut ways = survey(mission, &positions, start, begin.seconds()).ok();
    // A cycle is flown again and again by the ways of its first lap.
    let mut departs_s = vec![0.0];
    departs_s.extend(plan.visits.iter().map(|visit| visit.end_s));
    let mut route = |from: Option<usize>, to: usize, number: usize| {
        let depart_s = departs_s.get(number).or(departs_s.last()).copied().unwrap_or(0.0);
        ways.as_mut().map_or_else(Vec::new, |ways| ways.route(from, to, depart_s))
    };
    let mut order: Vec<usize> =
        order.iter().filter_map(|name| sites.iter().position(|(target, _)| target.id == **name)).collect();
    if repeat {
        // A cycle is flown again from its first site, so the way from the start is better one without bends.
        let open = order.iter().position(|site| route(None, *site, 0).len() == 2);
        order.rotate_left(open.unwrap_or(0));
    }
    // Who cannot hover looks from a circle around the site.
    let circles = mission.model.airframe == Airframe::FixedWing;
    let mut steps = Vec::new();
    let mut before = None;
    for (index, number) in order.iter().enumerate() {
        let Some((target, dwell_s)) = sites.get(*number) else { continue };
        let altitude_m = visit_altitude_m(mission, target);
        if before.is_some() || !repeat {
            detour(&mut steps, &route(before, *number, index), altitude_m);
        }
        before = Some(*number);
        let form = Value::list([
            Value::symbol("visit"),
            Value::symbol(&target.id),
            Value::symbol(if circles { "around" } else { "at" }),
            at(target.position, altitude_m),
            Value::symbol("for"),
            Value::Duration(Duration::from_seconds(*dwell_s)),
        ]);
        steps.push((Symbol::new(&format!("visit-{}-{}", index + 1, target.id)), form));
    }
    if let (true, Some(first), Some(last)) = (repeat, order.first(), order.last()) {
        let altitude_m = sites.get(*first).map_or(0.0, |(target, _)| visit_altitude_m(mission, target));
        detour(&mut steps, &route(Some(*last), *first, order.len()), altitude_m);
    }
    (steps, repeat)
}

/// A location rounded to about a metre, so that plans stay readable.
fn at(position: Position, altitude_m: f64) -> Value {
    let round = |degrees: f64| (degrees * 1e5).round() / 1e5;
    Value::list([
        Value::Real(round(position.latitude_deg)),
        Value::Real(round(position.longitude_deg)),
        Value::Real(altitude_m.round()),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_way_that_opens_later_is_waited_for_where_it_begins() {
        let here = Position::new(40.0, -120.0);
        let mut steps = Vec::new();
        hold(&mut steps, &[here, here], 7000.0, 0.5);
        assert_eq!(steps, []);
        hold(&mut steps, &[here, here], 7000.0, 90.2);
        let printed = apex_pdl::print_plan(&Value::symbol("go"), &steps, false);
        assert!(printed.contains("(step hold-1 (loiter at (40.0 -120.0 7000.0) for P1M30S))"), "{printed}");
    }
}
