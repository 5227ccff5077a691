//! The plan in execution: adopted plans, remainders, and plans read back from stored procedures.

use super::*;
use crate::deliberation::{Deliberation, MissionDeliberator, PlanningResources, SolveOptions, solve, translate};
use crate::problem::pose;
use crate::situation::{Chosen, Situation};
use apex_model::because::{Because, Cause};
use apex_model::effect::{Decision, DecisionKind, Effect, SolveRequest, SolveRequestId};
use apex_model::event::{Batch, Event, EventKind, SolverReport};
use apex_model::symbol::Symbol;
use apex_model::task::TaskId;
use apex_planning::solver::{Environment, Solver};
use apex_runtime::invocation::Invocations;
use apex_runtime::ports::{CancelToken, Deliberator};
use apex_runtime::target_state::TargetState;
use std::sync::{Arc, Mutex};

fn mission(name: &str) -> Arc<Mission> {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../missions").join(name);
    Arc::new(Mission::load(&folder).unwrap())
}

/// The plan from which planning was to begin, and the resulting plan.
type Asked = (Option<Plan>, Plan);

/// Planner that records its starting plan and its answer, and plans like 2-Opt.
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
        let plan = apex_solvers::planners::two_opt::TwoOpt.solve(problem, environment)?;
        self.0.lock().unwrap().push((previous, plan.clone()));
        Ok(plan)
    }
}

#[test]
fn planners_begin_from_the_adopted_plan_only() {
    let seen = Arc::new(Mutex::new(Vec::new()));
    let mut planners = apex_solvers::shipped();
    planners.add(Arc::new(Spy(Arc::clone(&seen)))).unwrap();
    let means = PlanningResources::of(&Arc::new(planners));
    let mut deliberator = MissionDeliberator::new(mission("structure-watch"), means);
    let goal = Value::list([Value::symbol("patrol"), Value::symbol("the"), Value::symbol("structures")]);
    let step = |deliberator: &mut MissionDeliberator, at_s: f64, kinds: Vec<EventKind>, effects: &[Effect]| {
        let now = Time::from_seconds(at_s);
        let events = kinds.into_iter().map(|kind| Event { sequence: 0, at: now, kind }).collect();
        deliberator.observe(0, &Batch { now, events }, effects);
    };
    let ask = |deliberator: &mut MissionDeliberator, number: u64, at_s: f64| {
        let budget = Some(Duration::from_seconds(0.005));
        let (request, solver) = (SolveRequestId(number), Symbol::new("spy"));
        let (task, is_failure_handled) = (TaskId(1), false);
        let request = SolveRequest { request, task, goal: goal.clone(), solver, budget, is_failure_handled };
        step(deliberator, at_s, Vec::new(), &[Effect::Solve(request.clone())]);
        let answer = deliberator.pose(&request, Time::from_seconds(at_s)).job.run(&CancelToken::new());
        EventKind::SolverReported(SolveRequestId(number), SolverReport::Plan(answer.result.unwrap()))
    };
    ask(&mut deliberator, 0, 0.0);
    assert_eq!(deliberator.target_changes(), [], "the request was cancelled: the executive never adopts the plan");
    let answer = ask(&mut deliberator, 1, 60.0);
    let kind = DecisionKind::ProcedureAdded { request: SolveRequestId(1), summary: "a".into(), pdl: "b".into() };
    let because = Because::new(Cause::PlanArrived { request: SolveRequestId(1), solver: Symbol::new("spy") }, None);
    let adopted = Effect::Decided(Decision { task: None, kind, because });
    step(&mut deliberator, 70.0, vec![answer], &[adopted]);
    let changes = deliberator.target_changes().to_vec();
    assert!(!changes.is_empty() && changes.iter().all(|change| change.at == Time::from_seconds(70.0)), "{changes:?}");
    ask(&mut deliberator, 2, 320.0);
    ask(&mut deliberator, 3, 900.0);
    let seen = seen.lock().unwrap();
    let begun: Vec<bool> = seen.iter().map(|(previous, _)| previous.is_some()).collect();
    assert_eq!(begun, [false, false, true, true], "planners begin from adopted plans only");
    let whole = watch(&seen[1].1);
    // Each target is planned once, for the mission time of its first visit: times of the plan count from 60 s.
    let planned = changes.iter().filter(|change| change.state == TargetState::Planned);
    let planned: Vec<(&str, &str)> = planned.map(|change| (&*change.target, &*change.detail)).collect();
    let mut first: Vec<(&str, String)> = Vec::new();
    for visit in &whole.visits {
        if first.iter().all(|(target, _)| *target != visit.target) {
            let begin = Time::from_seconds((60.0 + visit.arrive_s).round());
            first.push((&visit.target, format!("for {begin}")));
        }
    }
    assert!(first.len() < whole.visits.len(), "some target is visited twice");
    assert_eq!(planned, first.iter().map(|(target, detail)| (*target, &**detail)).collect::<Vec<_>>());
    // The remainder of the plan of 60 s, at 320 s and at 900 s.
    for (ask, elapsed_s) in [(2, 260.0), (3, 840.0)] {
        let left = watch(seen[ask].0.as_ref().unwrap());
        let behind = whole.visits.iter().filter(|visit| visit.end_s <= elapsed_s).count();
        assert!(behind > 0 && left.visits == whole.visits[behind..], "{behind} visits are behind");
        assert_eq!(left.cycle, whole.cycle);
    }
}

fn solved(mission: &Mission, solver: Option<&str>) -> Deliberation {
    let problem = pose(mission, &Situation::default(), None, Time::ZERO).unwrap();
    let means = PlanningResources::of(&Arc::new(apex_solvers::shipped()));
    let wish = SolveOptions { means: &means, solver, budget: Duration::from_seconds(0.3), seed: 1, previous: None };
    solve(problem, wish, &mut Invocations::new(), &CancelToken::new()).unwrap()
}

/// Returns the visits among a plan's steps, as read back from goals.
fn forms(mission: &Mission, solved: &Deliberation) -> Vec<PlannedActivity> {
    let steps = translate(solved, &Value::symbol("go"), 1, mission).steps;
    steps.into_iter().filter_map(|step| visit(&Activity::Goal(Template::Constant(step.activity.goal())))).collect()
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
    let broken = apex_planning::checker::violations(&solved.problem, &Plan::Surveillance(reasoned));
    assert_eq!(broken, Vec::<String>::new(), "its times can be flown");
    let later = watched(problem, &forms, 2, true).unwrap();
    assert_eq!((&later.cycle[0], later.visits[0].target.as_str()), (&read.cycle[2], read.cycle[2].as_str()));
    assert_eq!(watched(problem, &forms, 2 * forms.len() + 2, true).unwrap(), later, "laps before do not count");
    let once = watched(problem, &forms, 2, false).unwrap();
    assert_eq!((once.cycle.len(), once.visits.len()), (0, forms.len() - 2));
    let PlannedActivity::Visit { from, at, dwell, camera, .. } = forms[0].clone() else { panic!("it is a visit") };
    let strange = PlannedActivity::Visit { site: "atlantis".into(), from, at, dwell, camera };
    let with: Vec<PlannedActivity> = [strange].into_iter().chain(forms).collect();
    assert_eq!(watched(problem, &with, 0, true).unwrap(), read, "what is not a target does not count");
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
        assert!((read.end_s - planned.end_s).abs() <= 0.5 && (read.worth - planned.worth).abs() < 1e-2 * planned.worth);
    }
    // A factor that falls during each observation counts with its value at the beginning.
    let mut fading = problem.clone();
    for visit in &read.visits {
        let target = fading.targets.iter_mut().find(|target| target.name == visit.target).unwrap();
        target.timing = vec![(visit.begin_s, 1.0), (visit.end_s, 0.5)];
    }
    let forms = forms(&mission, &solved);
    assert!(visited(&fading, &forms).unwrap().visits.iter().all(|visit| visit.timing == 1.0));
    // Visits without times follow each other.
    let timeless = |step: &PlannedActivity| match step.clone() {
        PlannedActivity::Observe { target, lines, .. } => PlannedActivity::Observe { target, lines, due: None },
        other => other,
    };
    let timeless: Vec<PlannedActivity> = forms.iter().map(timeless).collect();
    let read = visited(problem, &timeless).unwrap();
    assert_eq!((of(&read), read.visits[0].begin_s), (of(plan), problem.start_s));
    assert!(read.visits.windows(2).all(|pair| (pair[0].end_s - pair[1].begin_s).abs() < 1e-6));
}

/// Returns a copy of the mission that has the plan as a stored procedure, which was chosen for the goal at 100 s.
fn with_stored(name: &str, solved: &Deliberation, goal: &Value) -> (Mission, Situation) {
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
    let mut situation = Situation::default();
    for procedure in &mission.library.procedures {
        let steps = procedure.steps.iter().filter_map(|step| visit(&step.activity)).count();
        if steps > 0 && steps == forms(&mission, solved).len() {
            let goal = match plan.repeat {
                true => Value::list([Value::symbol("one-cycle-of"), goal.clone()]),
                false => goal.clone(),
            };
            let chosen = Chosen { place: procedure.place, since: Time::from_seconds(100.0) };
            situation.chosen.insert(goal.to_string(), chosen);
        }
    }
    assert_eq!(situation.chosen.len(), 1, "one procedure is the plan's");
    (mission, situation)
}

/// Adds observations of one second each, from the given seconds on.
fn observe(mission: &Mission, mut situation: Situation, observed: &[(&str, f64)]) -> Situation {
    for (target, at_s) in observed {
        for (head, at_s) in [("observing", *at_s), ("observed", at_s + 1.0)] {
            let form = Value::list([Value::symbol(head), Value::symbol(target)]);
            let (at, kind) = (Time::from_seconds(at_s), EventKind::Occurrence(form));
            let batch = Batch { now: at, events: vec![Event { sequence: 0, at, kind }] };
            situation.observe(mission, 0, &batch, &[]);
        }
    }
    assert_eq!(situation.observed().count(), observed.len());
    situation
}

#[test]
fn a_stored_cycle_is_left_where_its_own_visits_ended() {
    let goal = Value::list([Value::symbol("patrol"), Value::symbol("the"), Value::symbol("structures")]);
    let solved = solved(&mission("structure-watch"), Some("two-opt"));
    let (mission, situation) = with_stored("structure-watch", &solved, &goal);
    let left = |observed: &[(&str, f64)]| {
        let situation = observe(&mission, situation.clone(), observed);
        match stored(&mission, &situation, &goal, &solved.problem).unwrap() {
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
    assert_eq!(stored(&mission, &Situation::default(), &goal, &solved.problem), None, "nothing was chosen");
}

#[test]
fn stored_observations_are_left_from_the_first_that_was_not_made() {
    let goal = Value::list([Value::symbol("map"), Value::symbol("the"), Value::symbol("fires")]);
    let solved = solved(&mission("western-states"), None);
    let (mission, situation) = with_stored("western-states", &solved, &goal);
    let Plan::SingleVisit(plan) = &solved.plan else { panic!("of another kind") };
    let names: Vec<&str> = plan.visits.iter().map(|visit| visit.target.as_str()).collect();
    let situation = observe(&mission, situation, &[(names[0], 500.0), (names[1], 9_000.0)]);
    let left = stored(&mission, &situation, &goal, &solved.problem).unwrap();
    assert_eq!(left.targets(), names[2..]);
}
