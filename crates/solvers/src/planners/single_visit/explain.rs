//! Reasons for which a target is not visited, as text for operators.

use crate::routing::reach;
use crate::routing::schedule::{Choice, Infeasibility, Judged, Schedule};
use crate::routing::travel::PointKey;
use apex_geo::sun;
use apex_model::problem::{LeftOut, Light, Obstacle, SingleVisitProblem, SingleVisitTarget, TimeWindow};
use apex_planning::obstacle::LeftOutReason;
use apex_planning::solver::{Budget, WorkBudget};

/// Number of positions, those with the shortest detours, that are examined to explain why a target does not fit.
const GAPS_EXPLAINED: usize = 6;

/// Time by which limits are extended, in addition to twice the time of the flight, to explain which time a target needs.
const MORE_S: f64 = 86_400.0;

/// Begin of the reason of a target in a plan with others.
const BETWEEN: &str = "does not fit between the others: ";

/// Obstacles of visits of single targets.
pub(super) struct Troubles {
    /// For each target the reason why it cannot be the only visit; `None` if it can.
    alone: Vec<Option<LeftOutReason>>,
    /// For each target true if no plan can visit it.
    impossible: Vec<bool>,
}

impl Troubles {
    /// Tries each target as the only visit, and proves which of the failing ones no plan can visit.
    pub(super) fn new(schedule: &mut Schedule<'_>) -> Troubles {
        let count = schedule.problem.targets.len();
        let mut alone: Vec<Option<LeftOutReason>> = Vec::with_capacity(count);
        let mut late: Vec<usize> = Vec::new();
        for target in 0..count {
            alone.push(match trouble_alone(schedule, target) {
                Some(AloneTrouble::Late(over_s)) => {
                    late.push(target);
                    Some(late_text(schedule, over_s, true))
                }
                Some(AloneTrouble::Other(trouble)) => Some(trouble),
                None => None,
            });
        }
        for (target, over_s) in over_alone(schedule, &late) {
            if let Some(slot) = alone.get_mut(target) {
                *slot = Some(late_text(schedule, over_s, true));
            }
        }
        let suspects: Vec<usize> =
            (0..count).filter(|target| alone.get(*target).is_some_and(Option::is_some)).collect();
        let impossible = match suspects.is_empty() {
            true => vec![false; count],
            false => reach::out_of_reach(schedule, &suspects),
        };
        let mut troubles = Troubles { alone, impossible };
        // A target that must follow an impossible one is impossible too; a chain has at most as many links as there are targets.
        for _ in 0..schedule.problem.precedence.len() {
            for target in 0..count {
                troubles.follow(schedule, target);
            }
        }
        troubles
    }

    /// Marks a target as impossible if it must follow an impossible target.
    fn follow(&mut self, schedule: &Schedule<'_>, target: usize) {
        let blocked = schedule.earlier(target).iter().find(|earlier| !self.is_possible(**earlier));
        let name = blocked.and_then(|earlier| schedule.problem.targets.get(*earlier)).map(|target| &target.name);
        let slots = self.alone.get_mut(target).zip(self.impossible.get_mut(target));
        if let (Some(name), Some((alone, impossible @ false))) = (name, slots) {
            *impossible = true;
            alone.get_or_insert_with(|| format!("must follow {name}, which cannot be visited").into());
        }
    }

    /// Returns false if no plan visits the target.
    pub(super) fn is_possible(&self, target: usize) -> bool {
        self.impossible.get(target) == Some(&false)
    }

    /// Returns the targets that a plan may visit.
    pub(super) fn possible(&self) -> Vec<usize> {
        (0..self.impossible.len()).filter(|target| self.is_possible(*target)).collect()
    }

    /// Returns the targets that a plan may visit, but not as the only visit.
    pub(super) fn with_others(&self) -> Vec<usize> {
        let is_in_trouble = |target: &usize| self.alone(*target).is_some();
        self.possible().into_iter().filter(is_in_trouble).collect()
    }

    /// Returns the reason for which no plan visits the target; `None` if one may.
    pub(super) fn of_impossible(&self, target: usize) -> Option<&LeftOutReason> {
        self.alone(target).filter(|_| !self.is_possible(target))
    }

    /// Returns the reason for which the target cannot be the only visit; `None` if it can.
    fn alone(&self, target: usize) -> Option<&LeftOutReason> {
        self.alone.get(target).and_then(Option::as_ref)
    }
}

/// Returns the reason for which a visit of the target earns nothing; `None` if it earns something.
fn worthless(problem: &SingleVisitProblem, target: usize) -> Option<LeftOutReason> {
    let data = problem.targets.get(target)?;
    let best_quality = data.manoeuvres.iter().map(|manoeuvre| manoeuvre.quality.product()).fold(0.0, f64::max);
    (data.gain(best_quality * best_timing(data)) <= 0.0).then(|| Obstacle::Worthless.into())
}

/// Returns the greatest timing factor in the windows of a target: between its corners the factor changes linearly.
fn best_timing(target: &SingleVisitTarget) -> f64 {
    if target.windows.is_empty() {
        return target.timing.iter().map(|(_, factor)| *factor).reduce(f64::max).unwrap_or(1.0);
    }
    let of_window = |window: &TimeWindow| {
        let corners = target.timing.iter().map(|(time_s, _)| *time_s).filter(|time_s| window.contains(*time_s));
        let ends = [window.from_s, window.until_s];
        corners.chain(ends).map(|time_s| target.timing_at(time_s)).fold(0.0, f64::max)
    };
    target.windows.iter().map(of_window).fold(0.0, f64::max)
}

/// Reason for which a target cannot be the only visit.
enum AloneTrouble {
    /// The flight would end this many seconds too late, at least.
    Late(f64),
    /// Another reason.
    Other(LeftOutReason),
}

/// Returns, for those of the `late` targets that can be visited alone in a longer flight, the time by which it exceeds the limit of this
/// one: with the wait for windows and the way home.
fn over_alone(schedule: &Schedule<'_>, late: &[usize]) -> Vec<(usize, f64)> {
    if late.is_empty() {
        return Vec::new();
    }
    let problem = without_limits(schedule);
    let Ok(mut endless) = Schedule::new(&problem) else { return Vec::new() };
    let mut free = WorkBudget::new(u64::MAX);
    let over_s = |target: &usize| {
        let manoeuvres = problem.targets.get(*target).map_or(0, |data| data.manoeuvres.len());
        let ends = (0..manoeuvres).filter_map(|manoeuvre| {
            let choice = Choice { target: *target, manoeuvre, not_before_s: f64::NEG_INFINITY };
            endless.judge(&[choice], &mut free).ok().map(|judged| judged.end_s)
        });
        let over_s = ends.fold(f64::INFINITY, f64::min) - schedule.limit_s;
        (over_s.is_finite() && over_s > 0.0).then_some((*target, over_s))
    };
    late.iter().filter_map(over_s).collect()
}

fn trouble_alone(schedule: &mut Schedule<'_>, target: usize) -> Option<AloneTrouble> {
    let data = schedule.problem.targets.get(target)?;
    // A way that is closed now may be open after other visits, when a zone is no longer active.
    let openings: Vec<f64> = schedule
        .problem
        .zones
        .iter()
        .flat_map(|zone| [zone.active.from_s, zone.active.until_s])
        .filter(|time_s| *time_s > schedule.problem.start_s && *time_s < schedule.limit_s)
        .collect();
    let mut first_trouble: Option<LeftOutReason> = None;
    let mut least_over_s = f64::INFINITY;
    for manoeuvre in 0..data.manoeuvres.len() {
        let choice = Choice { target, manoeuvre, not_before_s: f64::NEG_INFINITY };
        let outcome = flown_alone(schedule, choice, schedule.problem.start_s);
        if outcome.is_ok() || openings.iter().any(|open_s| flown_alone(schedule, choice, *open_s).is_ok()) {
            return None;
        }
        match outcome {
            Ok(()) => {}
            Err(Infeasibility::TooLate { over_s }) => least_over_s = least_over_s.min(over_s),
            Err(Infeasibility::Impossible(trouble)) => {
                first_trouble.get_or_insert_with(|| trouble.into());
            }
            Err(Infeasibility::Closed { target: closed }) => {
                first_trouble.get_or_insert_with(|| window_trouble(schedule, target, closed));
            }
            Err(Infeasibility::Order) => {}
        }
    }
    if least_over_s.is_finite() {
        return Some(AloneTrouble::Late(least_over_s));
    }
    first_trouble.map(AloneTrouble::Other)
}

/// Returns the reason for a visit after which the flight ends `over_s` seconds later than its limit allows.
fn late_text(schedule: &Schedule<'_>, over_s: f64, alone: bool) -> LeftOutReason {
    Obstacle::Late { over_s, limit: schedule.limit.of_visit(), alone }.into()
}

/// Returns the reason for a target that cannot be visited because the windows of `closed` are over, with the light that it needs.
fn window_trouble(schedule: &Schedule<'_>, target: usize, closed: usize) -> LeftOutReason {
    let trouble = closed_window(schedule, target, closed);
    let problem = schedule.problem;
    let Some(target) = problem.targets.get(target) else { return trouble };
    let (noun, time) = match target.light {
        Light::Day => ("day", "by daylight"),
        Light::Night => ("night", "by night"),
        Light::Any => return trouble,
    };
    let (from_s, until_s) = (problem.start_s, schedule.limit_s);
    match sun::light_windows(target.light, target.position, problem.zero_unix_s, from_s, until_s).is_empty() {
        true => format!("it is not {noun} there before the flight must end").into(),
        false => LeftOutReason { text: format!("{} {time}", trouble.text), ..trouble },
    }
}

/// Returns the reason that the windows of `closed` are over: an obstacle of `target` if they are its windows, else one that names them.
fn closed_window(schedule: &Schedule<'_>, target: usize, closed: usize) -> LeftOutReason {
    if closed == target { Obstacle::Window.into() } else { schedule.closed_window(closed).into() }
}

/// Checks that the one target can be flown to, observed, and flown home from, leaving at `start_s`. Names airspace before anything else.
fn flown_alone(schedule: &mut Schedule<'_>, choice: Choice, start_s: f64) -> Result<(), Infeasibility> {
    let entry = PointKey::Entry(choice.target, choice.manoeuvre);
    let exit = PointKey::Exit(choice.target, choice.manoeuvre);
    let there = schedule.travel.times(PointKey::Start, entry, start_s).map_err(Infeasibility::Impossible)?;
    let manoeuvre =
        schedule.problem.targets.get(choice.target).and_then(|target| target.manoeuvres.get(choice.manoeuvre));
    let mut end_s = there.arrive_s + manoeuvre.map_or(0.0, |manoeuvre| manoeuvre.duration_s);
    if schedule.problem.base.is_some() {
        let home = schedule.travel.times(exit, PointKey::Base, end_s);
        end_s = home.map_err(|trouble| Infeasibility::Impossible(format!("on the way home {trouble}")))?.arrive_s;
    }
    let over_s = end_s - schedule.limit_s;
    if over_s > 0.0 {
        // Without a limit on the time, the visit may still be impossible, or have to wait.
        return Err(match schedule.visit(PointKey::Start, start_s, choice) {
            Err(trouble @ (Infeasibility::Impossible(_) | Infeasibility::Closed { .. })) => trouble,
            Err(Infeasibility::TooLate { over_s: waited_s }) => Infeasibility::TooLate { over_s: over_s.max(waited_s) },
            Ok(_) | Err(Infeasibility::Order) => Infeasibility::TooLate { over_s },
        });
    }
    let visit = schedule.visit(PointKey::Start, start_s, choice)?;
    let end_s = schedule.home_at_s(exit, visit.end_s)?;
    if end_s > schedule.limit_s { Err(Infeasibility::TooLate { over_s: end_s - schedule.limit_s }) } else { Ok(()) }
}

/// Returns the summary of a plan without visits: the most frequent reason first.
pub(super) fn nothing_visited(left_out: &[LeftOut], possible: bool) -> String {
    let mut reasons: Vec<(&String, Vec<&str>)> = Vec::new();
    for LeftOut { target, reason, .. } in left_out {
        match reasons.iter_mut().find(|(known, _)| *known == reason) {
            Some((_, names)) => names.push(target),
            None => reasons.push((reason, vec![target])),
        }
    }
    reasons.sort_by_key(|(_, names)| std::cmp::Reverse(names.len()));
    let listed: Vec<String> =
        reasons.iter().take(3).map(|(reason, names)| format!("{}: {reason}", names.join(", "))).collect();
    let what = if possible { "No visit improves the plan." } else { "No target can be visited." };
    format!("{what} {}.", listed.join("; "))
}

/// Returns the reasons of all targets that `order` leaves out.
pub(super) fn left_out(
    schedule: &mut Schedule<'_>,
    order: &[Choice],
    judged: &Judged,
    troubles: &Troubles,
) -> Vec<LeftOut> {
    let mut all = left_out_quickly(schedule, order, judged, troubles);
    let unknown: Vec<(usize, &mut LeftOut)> = all
        .iter_mut()
        .filter_map(|left_out| {
            let target = schedule.problem.targets.iter().position(|target| target.name == left_out.target)?;
            let is_known = troubles.of_impossible(target).is_some() || worthless(schedule.problem, target).is_some();
            (!is_known).then_some((target, left_out))
        })
        .collect();
    if unknown.is_empty() {
        return all;
    }
    let endless = without_limits(schedule);
    let mut endless = Schedule::new(&endless).ok();
    for (target, left_out) in unknown {
        reason_beside((schedule, endless.as_mut()), order, judged, target).replace_in(left_out);
    }
    all
}

/// Returns the problem with limits on time and energy that come much later.
fn without_limits(schedule: &Schedule<'_>) -> SingleVisitProblem {
    let more_s = MORE_S + 2.0 * (schedule.limit_s - schedule.problem.start_s);
    let mut problem = schedule.problem.clone();
    problem.end_s = problem.end_s.map(|end_s| end_s + more_s);
    problem.vehicle.endurance_s += more_s;
    problem.vehicle.fuel_kg += more_s * problem.vehicle.fuel_flow_kg_per_s;
    problem
}

/// Like [`left_out`], without computing reasons that are not known yet.
pub(super) fn left_out_quickly(
    schedule: &mut Schedule<'_>,
    order: &[Choice],
    _judged: &Judged,
    troubles: &Troubles,
) -> Vec<LeftOut> {
    let problem = schedule.problem;
    let mut seen = vec![false; problem.targets.len()];
    for choice in order {
        if let Some(seen) = seen.get_mut(choice.target) {
            *seen = true;
        }
    }
    let missing = problem.targets.iter().enumerate().filter(|(target, _)| seen.get(*target) == Some(&false));
    missing
        .map(|(target, data)| {
            let known = worthless(problem, target).or_else(|| troubles.of_impossible(target).cloned());
            known.unwrap_or_else(|| "is not in the best plan so far".into()).of(data.name.clone())
        })
        .collect()
}

/// Returns the reason for which a target that could be the only visit does not fit into the plan. `endless` is the schedule without limits
/// on time and energy: a flight that ends too late is followed to its end, so that the missing time suffices for this order.
fn reason_beside(
    (schedule, endless): (&mut Schedule<'_>, Option<&mut Schedule<'_>>),
    order: &[Choice],
    judged: &Judged,
    target: usize,
) -> LeftOutReason {
    let earlier =
        schedule.earlier(target).iter().find(|earlier| !order.iter().any(|choice| choice.target == **earlier));
    if let Some(earlier) = earlier.and_then(|earlier| schedule.problem.targets.get(*earlier)) {
        return format!("must follow {}, which is left out", earlier.name).into();
    }
    let within = inserted_somewhere(schedule, order, target);
    if let Some((score, _)) = within.best {
        let loss = judged.score - score;
        return match loss {
            _ if loss > 0.0 => Obstacle::Score { loss }.into(),
            _ if loss < 0.0 => "was not reached within the planning budget".into(),
            _ => "would not raise the score".into(),
        };
    }
    let limit_s = schedule.limit_s;
    match endless.and_then(|endless| inserted_somewhere(endless, order, target).best) {
        // More time would not make the visit pay.
        Some((score, _)) if score < judged.score => Obstacle::Score { loss: judged.score - score }.into(),
        Some((_, end_s)) if end_s > limit_s => late_text(schedule, end_s - limit_s, false),
        _ => within.trouble.unwrap_or_else(|| match order.is_empty() {
            true => "no way leads there and back".into(),
            false => "does not fit between the others".into(),
        }),
    }
}

/// Result of inserting a target at the positions of an order.
struct Inserted {
    /// Highest score, and the end of that flight; `None` if no insertion can be flown.
    best: Option<(f64, f64)>,
    /// Reason of an insertion that cannot be flown at all.
    trouble: Option<LeftOutReason>,
}

fn inserted_somewhere(schedule: &mut Schedule<'_>, order: &[Choice], target: usize) -> Inserted {
    let mut free = WorkBudget::new(u64::MAX);
    let budget: &mut dyn Budget = &mut free;
    let manoeuvres = schedule.problem.targets.get(target).map_or(0, |target| target.manoeuvres.len());
    let mut inserted = Inserted { best: None, trouble: None };
    let between = if order.is_empty() { "" } else { BETWEEN };
    for manoeuvre in 0..manoeuvres {
        for at in nearest_gaps(schedule, order, target, manoeuvre) {
            let mut with = order.to_vec();
            with.insert(at, Choice { target, manoeuvre, not_before_s: f64::NEG_INFINITY });
            match schedule.judge(&with, budget) {
                Ok(Judged { score, end_s, .. }) if inserted.best.is_none_or(|(best, _)| score > best) => {
                    inserted.best = Some((score, end_s));
                }
                Err(Infeasibility::Impossible(why)) => {
                    inserted.trouble = Some(LeftOutReason::from(why).after(between));
                }
                Err(Infeasibility::Closed { target: closed }) => {
                    inserted.trouble = Some(closed_window(schedule, target, closed).after(between));
                }
                Ok(_) | Err(Infeasibility::TooLate { .. } | Infeasibility::Order) => {}
            }
        }
    }
    inserted
}

/// Returns the positions in `order` where `target` adds the shortest detour by least travel times, the shortest first.
fn nearest_gaps(schedule: &Schedule<'_>, order: &[Choice], target: usize, manoeuvre: usize) -> Vec<usize> {
    let (entry, exit) = (PointKey::Entry(target, manoeuvre), PointKey::Exit(target, manoeuvre));
    let travel = &schedule.travel;
    let detour_s = |at: usize| {
        let before = at.checked_sub(1).and_then(|before| order.get(before));
        let before = before.map_or(PointKey::Start, |choice| PointKey::Exit(choice.target, choice.manoeuvre));
        let next = order.get(at).map(|choice| PointKey::Entry(choice.target, choice.manoeuvre));
        let next = next.or(schedule.problem.base.map(|_| PointKey::Base));
        let direct_s = next.map_or(0.0, |next| travel.time_s_min(before, next));
        travel.time_s_min(before, entry) + next.map_or(0.0, |next| travel.time_s_min(exit, next)) - direct_s
    };
    let mut gaps: Vec<(f64, usize)> = (0..=order.len()).map(|at| (detour_s(at), at)).collect();
    gaps.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    gaps.into_iter().take(GAPS_EXPLAINED).map(|(_, at)| at).collect()
}
