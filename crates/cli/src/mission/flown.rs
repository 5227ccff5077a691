//! The plan that is flown when the mission plans again: where planners begin.
//!
//! It is the last plan that the executive took; an answer that nobody wanted any more is none. Before the first, it is the stored
//! procedure that was chosen for the goal, as `apex plan --format pdl` prints one: its steps are read back, others of its
//! steps do not count.

use super::Mission;
use super::bookkeeping::Bookkeeping;
use super::steps::observed_lines;
use apex_metrics::eci;
use apex_model::effect::{SolveRequest, SolveRequestId};
use apex_model::expression::Template;
use apex_model::limits::SOLVE_REQUESTS_MAX;
use apex_model::problem::{
    Plan, PlannedVisit, Problem, SingleVisitPlan, SingleVisitProblem, SurveillancePlan, SurveillanceProblem,
    SurveillanceVisit, UNREACHABLE_S,
};
use apex_model::procedure::{Activity, Procedure};
use apex_model::source::Place;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use std::collections::BTreeMap;

/// Who made a plan that is read from a stored procedure.
const STORED: &str = "stored";
/// Visits of such a plan at most.
const VISITS_MAX: usize = 10_000;

/// Plans that were made, and the one that is flown.
#[derive(Debug, Default)]
pub(super) struct Flown {
    /// Answers of which it is not known whether the executive takes them.
    answers: BTreeMap<SolveRequestId, (Plan, Time)>,
    /// The last one taken, and when it was made.
    taken: Option<(Plan, Time)>,
}

impl Flown {
    /// A request made at `at` is answered by this plan.
    pub(super) fn answered(&mut self, request: SolveRequestId, plan: Plan, at: Time) {
        self.answers.insert(request, (plan, at));
        // Those of which nothing was heard for long will not be taken.
        while self.answers.len() > SOLVE_REQUESTS_MAX {
            self.answers.pop_first();
        }
    }

    /// What is left at `at` of the plan that is flown for the request's goal, and how it came to be.
    pub(super) fn plan(
        &mut self,
        (mission, books): (&Mission, &Bookkeeping),
        request: &SolveRequest,
        problem: &Problem,
        at: Time,
    ) -> Option<(Plan, &'static str)> {
        if let Some(taken) = books.plan_taken.and_then(|taken| self.answers.remove(&taken)) {
            self.taken = Some(taken);
        }
        let made = self.taken.clone().map(|(plan, made)| (ahead(plan, at - made), "the plan that is flown"));
        made.or_else(|| Some((stored(mission, books, &request.goal, problem)?, "the stored plan that is flown")))
    }
}

/// What is left of a plan `elapsed` after it was made. Problems of surveillance begin at their own now, the others at the mission's.
fn ahead(plan: Plan, elapsed: Duration) -> Plan {
    match plan {
        Plan::SingleVisit(plan) => Plan::SingleVisit(plan),
        Plan::Surveillance(mut plan) => {
            plan.visits.retain(|visit| visit.end_s > elapsed.seconds());
            Plan::Surveillance(plan)
        }
    }
}

/// What is left of the stored procedure that was chosen for the goal, as a plan for the problem as it is now.
fn stored(mission: &Mission, books: &Bookkeeping, goal: &Value, problem: &Problem) -> Option<Plan> {
    let lap = Value::list([Value::symbol("one-cycle-of"), goal.clone()]);
    let chosen = |goal: &Value| {
        books.chosen.get(&goal.to_string()).and_then(|chosen| Some((chosen, procedure(mission, chosen.place)?)))
    };
    let (chosen, procedure, repeat) = match chosen(&lap) {
        Some((chosen, procedure)) => (chosen, procedure, true),
        None => chosen(goal).map(|(chosen, procedure)| (chosen, procedure, false))?,
    };
    let steps: Vec<Value> = procedure.steps.iter().filter_map(|step| visit(&step.activity)).collect();
    // Visits since then, as far as they are the procedure's.
    let mut done = 0;
    for seen in books.observed().filter(|visit| visit.begin >= chosen.since) {
        let next = if repeat { steps.get(done % steps.len().max(1)) } else { steps.get(done) };
        done += usize::from(next.and_then(target).is_some_and(|target| target == seen.target));
    }
    match problem {
        Problem::Surveillance(problem) => watched(problem, &steps, done, repeat).map(Plan::Surveillance),
        Problem::SingleVisit(problem) => visited(problem, steps.get(done..)?).map(Plan::SingleVisit),
    }
}

fn procedure(mission: &Mission, place: Place) -> Option<&Procedure> {
    mission.library.procedures.iter().map(AsRef::as_ref).find(|procedure| procedure.place == place)
}

/// The form of a step that visits a target: `(observe TARGET ..)` or `(visit TARGET ..)` without variables.
fn visit(activity: &Activity) -> Option<Value> {
    let Activity::Goal(Template::Constant(form)) = activity else { return None };
    let head = form.as_list()?.first()?.as_symbol()?;
    (head.is("observe") || head.is("visit")).then(|| form.clone())
}

fn target(form: &Value) -> Option<String> {
    form.as_list()?.get(1).map(ToString::to_string)
}

/// The visits from `done` on with their times from now on, until the horizon where they are repeated.
fn watched(problem: &SurveillanceProblem, steps: &[Value], done: usize, repeat: bool) -> Option<SurveillancePlan> {
    let index = |form: &Value| {
        let name = target(form)?;
        problem.targets.iter().position(|target| target.name == name)
    };
    let done = if repeat { done % steps.len().max(1) } else { done };
    let known = |steps: &[Value]| steps.iter().filter_map(index).collect::<Vec<usize>>();
    let (ahead, behind) = (known(steps.get(done..)?), known(steps.get(..done)?));
    let cycle: Vec<usize> = if repeat { ahead.iter().chain(&behind).copied().collect() } else { Vec::new() };
    let order = if repeat { cycle.iter().cycle().take(VISITS_MAX) } else { ahead.iter().cycle().take(ahead.len()) };
    let (mut visits, mut place, mut time_s) = (Vec::new(), None, 0.0);
    for target in order {
        let data = problem.targets.get(*target)?;
        let from_start = || problem.travel.start_to_at(*target, time_s);
        let travel_s = place.map_or_else(from_start, |from| problem.travel.between_at(from, *target, time_s));
        let arrive_s = time_s + travel_s;
        (place, time_s) = (Some(*target), arrive_s + data.dwell_s);
        if travel_s >= UNREACHABLE_S || time_s > problem.horizon_s {
            break;
        }
        visits.push(SurveillanceVisit { target: data.name.clone(), arrive_s, end_s: time_s });
    }
    let name = |target: &usize| problem.targets.get(*target).map(|target| target.name.clone());
    let cycle: Vec<String> = cycle.iter().filter_map(name).collect();
    (!visits.is_empty()).then(|| SurveillancePlan {
        solver: STORED.to_string(),
        cycle,
        return_s: None,
        expected_cost: eci::expected_cost(problem, &visits).total,
        expected_cost_bound: None,
        left_out: Vec::new(),
        summary: String::new(),
        visits,
    })
}

/// The observations, each in the manoeuvre whose lines the step flies, when the step expects it.
fn visited(problem: &SingleVisitProblem, steps: &[Value]) -> Option<SingleVisitPlan> {
    let mut visits = Vec::new();
    let mut ready_s = problem.start_s;
    for form in steps {
        let name = target(form);
        let Some(of) = problem.targets.iter().find(|target| Some(&target.name) == name.as_ref()) else { continue };
        let flies = |manoeuvre: &&apex_model::problem::Manoeuvre| {
            form.as_list()?.get(3).map(|lines| *lines == observed_lines(manoeuvre))
        };
        let number = of.manoeuvres.iter().position(|manoeuvre| flies(&manoeuvre) == Some(true)).unwrap_or(0);
        let Some(manoeuvre) = of.manoeuvres.get(number) else { continue };
        let due_s = form.as_list().and_then(|form| match form.get(5) {
            Some(Value::Duration(due)) => Some(due.seconds()),
            _ => None,
        });
        let end_s = due_s.unwrap_or(ready_s + manoeuvre.duration_s);
        let begin_s = end_s - manoeuvre.duration_s;
        let timing = of.timing_at(begin_s);
        visits.push(PlannedVisit {
            target: of.name.clone(),
            manoeuvre: number,
            route: Vec::new(),
            path: Vec::new(),
            depart_s: ready_s,
            arrive_s: begin_s,
            begin_s,
            end_s,
            timing,
            worth: of.value * manoeuvre.quality.product() * timing,
        });
        ready_s = end_s;
    }
    let benefits = visits.iter().map(|visit| visit.worth).sum();
    (!visits.is_empty()).then(|| SingleVisitPlan {
        solver: STORED.to_string(),
        visits,
        return_route: Vec::new(),
        return_path: Vec::new(),
        return_depart_s: ready_s,
        end_s: ready_s,
        fuel_used_kg: 0.0,
        benefits,
        costs: 0.0,
        score: benefits,
        benefits_bound: None,
        left_out: Vec::new(),
        summary: String::new(),
    })
}

#[cfg(test)]
mod tests {
    use super::super::bookkeeping::{BookkeepingObserver, Chosen, SharedBookkeeping, lock};
    use super::super::deliberator::{Deliberation, Means, MissionDeliberator, Wish, solve, translate};
    use super::super::problem::pose;
    use super::*;
    use apex_model::because::{Because, Cause};
    use apex_model::effect::{Decision, DecisionKind, Effect};
    use apex_model::event::{Batch, Event, EventKind};
    use apex_model::solver::{Environment, Solver};
    use apex_model::symbol::Symbol;
    use apex_model::task::TaskId;
    use apex_runtime::invocation::Invocations;
    use apex_runtime::ports::{Deliberator, Observer, Withdrawal};
    use apex_solvers::Registry;
    use std::sync::{Arc, Mutex};

    fn mission(name: &str) -> Arc<Mission> {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../missions").join(name);
        Arc::new(Mission::load(&folder).unwrap())
    }

    /// Where planning was to begin, and what was planned.
    type Asked = (Option<Plan>, Plan);

    /// Remembers where it was to begin and what it has planned, as 2-Opt does.
    struct Spy(Arc<Mutex<Vec<Asked>>>);

    fn watch(plan: &Plan) -> &SurveillancePlan {
        let Plan::Surveillance(plan) = plan else { panic!("of another kind") };
        plan
    }

    impl Solver for Spy {
        fn name(&self) -> &'static str {
            "spy"
        }
        fn serves(&self, _: &Problem) -> bool {
            true
        }
        fn solve(&self, problem: &Problem, environment: &mut Environment<'_>) -> Result<Plan, String> {
            let previous = environment.previous.cloned();
            let plan = apex_solvers::two_opt::TwoOpt.solve(problem, environment)?;
            self.0.lock().unwrap().push((previous, plan.clone()));
            Ok(plan)
        }
    }

    #[test]
    fn an_answer_that_nobody_took_is_no_flown_plan() {
        let (seen, books) = (Arc::new(Mutex::new(Vec::new())), SharedBookkeeping::default());
        let mut planners = Registry::shipped();
        planners.add(Arc::new(Spy(Arc::clone(&seen)))).unwrap();
        let means = Means::of(&Arc::new(planners));
        let mut deliberator = MissionDeliberator::new(mission("structure-watch"), Arc::clone(&books), means);
        let goal = Value::list([Value::symbol("patrol"), Value::symbol("the"), Value::symbol("structures")]);
        let mut ask = |number: u64, at_s: f64| {
            let budget = Some(Duration::from_seconds(0.005));
            let (request, solver) = (SolveRequestId(number), Symbol::new("spy"));
            let request = SolveRequest { request, task: TaskId(1), goal: goal.clone(), solver, budget };
            let answer = deliberator.deliberate(&request, Time::from_seconds(at_s), &Withdrawal::new());
            answer.result.unwrap();
        };
        ask(0, 0.0);
        // Cancelled meanwhile: the executive never takes it.
        assert_eq!(lock(&books).target_changes, []);
        ask(1, 60.0);
        let kind = DecisionKind::ProcedureAdded { request: SolveRequestId(1), summary: "a".into(), pdl: "b".into() };
        let because = Because::new(Cause::PlanArrived { request: SolveRequestId(1), solver: Symbol::new("spy") }, None);
        let taken = Effect::Decided(Decision { task: None, kind, because });
        let batch = Batch { now: Time::from_seconds(70.0), events: Vec::new() };
        BookkeepingObserver::new(Arc::clone(&books)).observe(&batch, &[taken]).unwrap();
        let told = std::mem::take(&mut lock(&books).target_changes);
        assert!(!told.is_empty() && told.iter().all(|(_, at, ..)| *at == batch.now), "{told:?}");
        ask(2, 320.0);
        ask(3, 900.0);
        let seen = seen.lock().unwrap();
        let begun: Vec<bool> = seen.iter().map(|(previous, _)| previous.is_some()).collect();
        assert_eq!(begun, [false, false, true, true], "only what was taken is begun from");
        // Of the plan of 60 s what is ahead at 320 s and at 900 s.
        let whole = watch(&seen[1].1);
        for (ask, elapsed_s) in [(2, 260.0), (3, 840.0)] {
            let left = watch(seen[ask].0.as_ref().unwrap());
            let behind = whole.visits.iter().filter(|visit| visit.end_s <= elapsed_s).count();
            assert!(behind > 0 && left.visits == whole.visits[behind..], "{behind} visits are behind");
            assert_eq!(left.cycle, whole.cycle);
        }
    }

    #[test]
    fn answers_of_which_nothing_is_heard_are_forgotten_the_oldest_first() {
        let mut flown = Flown::default();
        let plan = Plan::Surveillance(SurveillancePlan {
            solver: STORED.to_string(),
            cycle: Vec::new(),
            return_s: None,
            expected_cost: 0.0,
            expected_cost_bound: None,
            left_out: Vec::new(),
            summary: String::new(),
            visits: Vec::new(),
        });
        for number in 0..SOLVE_REQUESTS_MAX as u64 + 3 {
            flown.answered(SolveRequestId(number), plan.clone(), Time::ZERO);
        }
        assert_eq!(
            (flown.answers.len(), flown.answers.first_key_value().map(|(request, _)| request.0)),
            (SOLVE_REQUESTS_MAX, Some(3))
        );
    }

    fn solved(mission: &Mission, solver: Option<&str>) -> Deliberation {
        let problem = pose(mission, &Bookkeeping::default(), Time::ZERO).unwrap();
        let means = Means::of(&Arc::new(Registry::shipped()));
        let wish = Wish { means: &means, solver, budget: Duration::from_seconds(0.3), seed: 1, previous: None };
        solve(problem, wish, &mut Invocations::new(), &Withdrawal::new()).unwrap()
    }

    /// The forms of a plan's steps.
    fn forms(mission: &Mission, solved: &Deliberation) -> Vec<Value> {
        let steps = translate(solved, &Value::symbol("go"), 1, mission).steps;
        steps.into_iter().filter_map(|(_, activity)| visit(&Activity::Goal(activity))).collect()
    }

    #[test]
    fn a_cycle_is_read_back_where_it_stands() {
        let mission = mission("structure-watch");
        let solved = solved(&mission, Some("two-opt"));
        let (Problem::Surveillance(problem), Plan::Surveillance(plan)) = (&solved.problem, &solved.plan) else {
            panic!("of another kind")
        };
        let forms = forms(&mission, &solved);
        assert!(plan.cycle.len() > 3 && forms.len() == plan.cycle.len());
        let read = watched(problem, &forms, 0, true).unwrap();
        // A printed cycle may begin elsewhere.
        let first = plan.cycle.iter().position(|name| *name == read.cycle[0]).unwrap();
        let turned: Vec<String> = plan.cycle.iter().cycle().skip(first).take(plan.cycle.len()).cloned().collect();
        assert_eq!(read.cycle, turned);
        assert_eq!(read.visits.len().abs_diff(plan.visits.len()) / 3, 0, "the same horizon holds as many visits");
        let reasoned = SurveillancePlan { left_out: plan.left_out.clone(), ..read.clone() };
        let broken = apex_solvers::checker::violations(&solved.problem, &Plan::Surveillance(reasoned));
        assert_eq!(broken, Vec::<String>::new(), "its times can be flown");
        let later = watched(problem, &forms, 2, true).unwrap();
        assert_eq!((&later.cycle[0], later.visits[0].target.as_str()), (&read.cycle[2], read.cycle[2].as_str()));
        assert_eq!(watched(problem, &forms, 2 * forms.len() + 2, true).unwrap(), later, "laps before do not count");
        let once = watched(problem, &forms, 2, false).unwrap();
        assert_eq!((once.cycle.len(), once.visits.len()), (0, forms.len() - 2));
        let strange = Value::list([Value::symbol("visit"), Value::symbol("atlantis")]);
        let with: Vec<Value> = [strange].into_iter().chain(forms).collect();
        assert_eq!(watched(problem, &with, 0, true).unwrap(), read, "what is no target does not count");
        assert_eq!(watched(problem, &[], 0, true), None);
    }

    #[test]
    fn observations_are_read_back_with_their_manoeuvres() {
        let mission = mission("western-states");
        let solved = solved(&mission, None);
        let (Problem::SingleVisit(problem), Plan::SingleVisit(plan)) = (&solved.problem, &solved.plan) else {
            panic!("of another kind")
        };
        let read = visited(problem, &forms(&mission, &solved)).unwrap();
        let of = |plan: &SingleVisitPlan| -> Vec<(String, usize)> {
            plan.visits.iter().map(|visit| (visit.target.clone(), visit.manoeuvre)).collect()
        };
        assert!(of(plan).len() > 3);
        assert_eq!(of(&read), of(plan));
        for (read, planned) in read.visits.iter().zip(&plan.visits) {
            assert!(
                (read.end_s - planned.end_s).abs() <= 0.5 && (read.worth - planned.worth).abs() < 1e-2 * planned.worth
            );
        }
        // A factor that falls in the course of each observation counts as it is when that begins.
        let mut fading = problem.clone();
        for visit in &read.visits {
            let target = fading.targets.iter_mut().find(|target| target.name == visit.target).unwrap();
            target.timing = vec![(visit.begin_s, 1.0), (visit.end_s, 0.5)];
        }
        let forms = forms(&mission, &solved);
        assert!(visited(&fading, &forms).unwrap().visits.iter().all(|visit| visit.timing == 1.0));
        // Without times they follow each other.
        let timeless: Vec<Value> =
            forms.iter().map(|form| Value::list(form.as_list().unwrap().iter().take(4).cloned())).collect();
        let read = visited(problem, &timeless).unwrap();
        assert_eq!((of(&read), read.visits[0].begin_s), (of(plan), problem.start_s));
        assert!(read.visits.windows(2).all(|pair| (pair[0].end_s - pair[1].begin_s).abs() < 1e-6));
    }

    /// A copy of the mission that has the plan as a stored procedure, which was chosen for the goal at 100 s.
    fn with_stored(name: &str, solved: &Deliberation, goal: &Value) -> (Mission, Bookkeeping) {
        let folder = tempfile::TempDir::new().unwrap();
        let shipped = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../missions").join(name);
        for entry in std::fs::read_dir(shipped).unwrap().map(Result::unwrap) {
            std::fs::copy(entry.path(), folder.path().join(entry.file_name())).unwrap();
        }
        let plan = translate(solved, goal, 1, &mission(name));
        std::fs::write(folder.path().join("plan.pdl"), plan.source.text.as_bytes()).unwrap();
        let program = folder.path().join("mission.pdl");
        let text = std::fs::read_to_string(&program).unwrap();
        std::fs::write(&program, text.replacen("  :targets", "  :files (\"plan.pdl\")\n  :targets", 1)).unwrap();
        let mission = Mission::load(folder.path()).unwrap();
        let mut books = Bookkeeping::default();
        for procedure in &mission.library.procedures {
            let steps = procedure.steps.iter().filter_map(|step| visit(&step.activity)).count();
            if steps > 0 && steps == forms(&mission, solved).len() {
                let goal = match plan.repeat {
                    true => Value::list([Value::symbol("one-cycle-of"), goal.clone()]),
                    false => goal.clone(),
                };
                let chosen = Chosen { place: procedure.place, since: Time::from_seconds(100.0) };
                books.chosen.insert(goal.to_string(), chosen);
            }
        }
        assert_eq!(books.chosen.len(), 1, "one procedure is the plan's");
        (mission, books)
    }

    /// Each target is observed from so many seconds on, for one second.
    fn observe(books: Bookkeeping, observed: &[(&str, f64)]) -> Bookkeeping {
        let books = Arc::new(Mutex::new(books));
        let mut observer = BookkeepingObserver::new(Arc::clone(&books));
        for (target, at_s) in observed {
            for (head, at_s) in [("observing", *at_s), ("observed", at_s + 1.0)] {
                let form = Value::list([Value::symbol(head), Value::symbol(target)]);
                let (at, kind) = (Time::from_seconds(at_s), EventKind::Occurrence(form));
                let batch = Batch { now: at, events: vec![Event { sequence: 0, at, kind }] };
                observer.observe(&batch, &[]).unwrap();
            }
        }
        let books = lock(&books).clone();
        assert_eq!(books.observed().count(), observed.len());
        books
    }

    #[test]
    fn a_stored_cycle_is_left_where_its_own_visits_ended() {
        let goal = Value::list([Value::symbol("patrol"), Value::symbol("the"), Value::symbol("structures")]);
        let solved = solved(&mission("structure-watch"), Some("two-opt"));
        let (mission, books) = with_stored("structure-watch", &solved, &goal);
        let left = |observed: &[(&str, f64)]| {
            let books = observe(books.clone(), observed);
            match stored(&mission, &books, &goal, &solved.problem).unwrap() {
                Plan::Surveillance(plan) => plan.cycle,
                Plan::SingleVisit(_) => panic!("of another kind"),
            }
        };
        let order = left(&[]);
        assert!(order.len() > 3);
        let from = |done: usize| order.iter().cycle().skip(done).take(order.len()).cloned().collect::<Vec<_>>();
        let [first, second, third] = [0, 1, 2].map(|at| order[at].as_str());
        assert_eq!(left(&[(first, 110.0), (second, 120.0)]), from(2));
        assert_eq!(left(&[(first, 10.0), (second, 20.0), (first, 110.0)]), from(1), "what came before does not count");
        assert_eq!(left(&[(third, 110.0), (first, 120.0), (first, 130.0)]), from(1), "nor what is not its next");
        let laps: Vec<(&str, f64)> =
            (0..order.len() + 1).map(|at| (order[at % order.len()].as_str(), 200.0 + 9.0 * at as f64)).collect();
        assert_eq!(left(&laps), from(1), "a lap later it stands where it stood");
        assert_eq!(stored(&mission, &Bookkeeping::default(), &goal, &solved.problem), None, "nothing was chosen");
    }

    #[test]
    fn stored_observations_are_left_from_the_first_that_was_not_made() {
        let goal = Value::list([Value::symbol("map"), Value::symbol("the"), Value::symbol("fires")]);
        let solved = solved(&mission("western-states"), None);
        let (mission, books) = with_stored("western-states", &solved, &goal);
        let Plan::SingleVisit(plan) = &solved.plan else { panic!("of another kind") };
        let names: Vec<&str> = plan.visits.iter().map(|visit| visit.target.as_str()).collect();
        let books = observe(books, &[(names[0], 500.0), (names[1], 9_000.0)]);
        let left = stored(&mission, &books, &goal, &solved.problem).unwrap();
        assert_eq!(left.targets(), names[2..]);
    }
}
