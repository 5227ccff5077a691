//! Every answer for an instant shows what was known at that instant: shipped missions are flown, and random instants of their records are
//! compared with the restored agent, and with the same record cut off at that instant.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing)]

use apex_executive::Agent;
use apex_executive::state::histories::history::Sample;
use apex_mission::Mission;
use apex_mission::deliberation::PlanningResources;
use apex_mission::flight::MissionFlight;
use apex_mission::recorded::{load_program, mission_of, replay, report_until, situation_at};
use apex_mission::report::MissionValue;
use apex_mission::score::ScoreHistory;
use apex_model::problem::{Plan, SurveillanceVisit};
use apex_model::source::SourceFile;
use apex_model::task::TaskState;
use apex_model::time::Time;
use apex_model::value::Value as ModelValue;
use apex_runtime::record::view::{
    EventsQuery, RecordView, SIGNALS_MAX, SignalKind, SignalQuery, TasksQuery, TimelineQuery, TrackQuery,
};
use apex_runtime::record::{RecordReader, seal_rows};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Budgets of planning in the programs of shipped missions, and the smaller ones of these flights: what the record shows does not depend
/// on the quality of plans, and planning would take most of the time of these tests.
const BUDGETS: [(&str, &str); 3] =
    [(":budget 500ms)", ":budget 50ms)"), (":budget 2s)", ":budget 200ms)"), (":budget 3s)", ":budget 300ms)")];

/// Flies a shipped mission for `hours` hours into a record in `folder`.
fn flown(folder: &Path, name: &str, hours: f64) -> PathBuf {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../missions").join(name);
    let copy = folder.join(name);
    std::fs::create_dir(&copy).unwrap();
    for file in std::fs::read_dir(shipped).unwrap() {
        let file = file.unwrap();
        std::fs::copy(file.path(), copy.join(file.file_name())).unwrap();
    }
    let program = std::fs::read_to_string(copy.join("mission.pdl")).unwrap();
    let program = BUDGETS.iter().fold(program, |program, (shipped, small)| program.replace(shipped, small));
    std::fs::write(copy.join("mission.pdl"), program).unwrap();
    let mission = Arc::new(Mission::load(&copy).unwrap());
    let record = folder.join(format!("{name}.apex"));
    let mut recorder = apex_simulation::create_record(&record, &mission, Some(1)).unwrap();
    let means = PlanningResources::of(&Arc::new(apex_solvers::shipped()));
    let terms = MissionFlight::terms(&mission, Some(Time::from_seconds(hours * 3_600.0)));
    apex_simulation::fly(mission, means, None, terms, &mut recorder, &mut []).unwrap();
    record
}

/// Returns the seed of the instants; `APEX_TRUTH_SEED=n` draws others.
fn seed() -> u64 {
    std::env::var("APEX_TRUTH_SEED").ok().map_or(42, |seed| seed.parse().unwrap())
}

/// Returns `count` instants of the record from the sequence of the seed, both ends included.
fn instants(reader: &RecordReader, count: u64) -> Vec<i64> {
    let (first, last) = reader.span().unwrap().unwrap();
    let mut generator = ChaCha8Rng::seed_from_u64(seed());
    let mut random = || i64::try_from(generator.next_u64() >> 11).unwrap().rem_euclid(last.0 - first.0 + 1) + first.0;
    let mut instants: Vec<i64> = (0..count).map(|_| random()).chain([first.0, last.0]).collect();
    instants.sort_unstable();
    instants
}

fn everything_at(at_ns: i64) -> TasksQuery {
    TasksQuery { at_ns: Some(at_ns), limit: Some(20_000), ..TasksQuery::default() }
}

/// Compares the newest values of the signals with those in the histories of the restored agent.
fn compare_signals(view: &mut RecordView, restored: &Agent, at: Time) {
    let shown = view.signals(Some(at.0), None).unwrap().signals;
    let numbers: Vec<_> = shown.iter().filter(|signal| signal.kind == SignalKind::Number).collect();
    for signal in &shown {
        let known = restored.histories.iter().any(|(variable, _)| variable.to_string() == signal.name);
        assert!(known, "{} is shown at {at}, and the agent does not know it", signal.name);
    }
    for names in numbers.chunks(SIGNALS_MAX) {
        let names: Vec<String> = names.iter().map(|signal| signal.name.clone()).collect();
        let asked = names.len();
        let all = SignalQuery { names, at_ns: Some(at.0), from_ns: Some(0), to_ns: Some(at.0), pixels: Some(1) };
        let windows = view.signal_windows(&all, None).unwrap().windows;
        assert_eq!(windows.len(), asked, "at {at}");
        for window in windows {
            let mut histories = restored.histories.iter();
            let (_, history) = histories.find(|(variable, _)| variable.to_string() == window.signal.name).unwrap();
            // The view shows printing units; the agent knows SI. A value of another kind than a number is not drawn.
            let number = |sample: &Sample| {
                let factor = match &sample.value {
                    ModelValue::Quantity(quantity) => quantity.unit().map_or(1.0, |unit| unit.factor),
                    _ => 1.0,
                };
                sample.value.as_number().map(|(si, _)| si / factor)
            };
            let Some(known) = history.samples().rev().find_map(number) else { continue };
            let last = window.statistics.unwrap().last;
            assert!(
                (known - last).abs() <= 1e-9 * known.abs().max(1.0),
                "{} at {at}: the page has {last}, the agent {known}",
                window.signal.name
            );
        }
    }
}

/// Compares the open holdings of the view with the holders in the resource table of the restored agent.
fn compare_holders(view: &mut RecordView, restored: &Agent, at: Time) {
    let sorted = |mut holders: Vec<(String, u64)>| {
        holders.sort();
        holders.dedup();
        holders
    };
    let shown = view.holdings((None, None), Some(at.0)).unwrap().resources;
    let shown = shown
        .iter()
        .flat_map(|row| row.holdings.iter().filter(|one| one.open).map(|one| (row.resource.clone(), one.task)));
    let known = restored
        .resources
        .iter()
        .flat_map(|(_, resource)| resource.holders.iter().map(|holder| (resource.name.to_string(), holder.task.0)));
    assert_eq!(sorted(shown.collect()), sorted(known.collect()), "holders at {at}");
}

/// Compares the plans of the view with the procedures that the restored agent has received from planners.
fn compare_plans(view: &RecordView, restored: &Agent, at: Time) {
    let shown = view.plans(Some(at.0)).unwrap();
    let added = shown.left_out + shown.plans.len() as i64;
    assert_eq!(added.cast_unsigned(), restored.next.generated, "plans at {at}");
    let in_force = view.plan(Some(at.0)).unwrap();
    assert_eq!(in_force.as_ref().map_or(0, |plan| plan.number), added, "the plan in force at {at}");
    let adopted = in_force.map_or(0, |plan| plan.adopted_ns);
    assert!(adopted <= at.0, "a plan of {adopted} ns is shown at {at}");
}

/// Compares the open questions of the view with those of the restored agent.
fn compare_questions(view: &RecordView, restored: &Agent, at: Time) {
    let shown = view.questions(Some(at.0)).unwrap().questions;
    assert!(shown.iter().all(|asked| asked.asked_ns <= at.0 && asked.closed_ns.is_none_or(|closed| closed <= at.0)));
    let open: BTreeSet<u64> = shown.iter().filter(|one| one.closed_ns.is_none()).map(|one| one.question).collect();
    let known: BTreeSet<u64> = restored.questions.keys().map(|question| question.0).collect();
    assert_eq!(open, known, "open questions at {at}");
}

/// Compares tasks, signals, holders, plans and questions of the view with the restored agent.
fn compare_with_agent(record: &Path, agent: usize, count: u64) {
    let reader = RecordReader::open(record).unwrap().of_agent(agent).unwrap();
    let mut view = RecordView::open(record, agent).unwrap();
    let load = |sources: &[SourceFile]| load_program(&reader, sources);
    let program = reader.load(&load).unwrap();
    for at_ns in instants(&reader, count) {
        let restored = reader.restore_with(Time(at_ns), &program).unwrap();
        let shown = view.tasks(&everything_at(at_ns)).unwrap().tasks;
        for (_, task) in restored.tasks.iter() {
            let at = Time(at_ns);
            let seen = shown.iter().find(|seen| seen.id == task.id.0);
            let seen = seen.unwrap_or_else(|| panic!("{} at {at} is not shown", task.id));
            assert_eq!(seen.state.0, task.state, "{} at {at}", task.id);
            assert_eq!(seen.parent, task.parent.map(|parent| parent.0), "{} at {at}", task.id);
            assert_eq!(
                seen.method.is_some(),
                task.selection.is_some() || !seen.state.is_alive() && seen.method.is_some()
            );
            if let Some(selection) = task.selection.as_ref().filter(|_| seen.state.is_alive()) {
                assert_eq!(seen.goal, selection.goal.to_string(), "{} at {at}", task.id);
            }
        }
        let alive = shown.iter().filter(|task| task.state.is_alive()).count();
        assert_eq!(
            alive,
            restored.tasks.iter().filter(|(_, task)| task.state != TaskState::Terminated).count(),
            "at {at_ns} ns"
        );
        compare_signals(&mut view, &restored, Time(at_ns));
        compare_holders(&mut view, &restored, Time(at_ns));
        compare_plans(&view, &restored, Time(at_ns));
        compare_questions(&view, &restored, Time(at_ns));
        let mission = view.mission(Some(at_ns)).unwrap();
        assert!(mission.ending.is_some() || mission.score.is_none(), "a score before the end at {at_ns} ns");
    }
}

/// Compares the score so far with that of a report made from the steps until then alone.
fn compare_score(record: &Path, count: u64) {
    let reader = RecordReader::open(record).unwrap();
    let mission = mission_of(&reader).unwrap().unwrap();
    let mut history = ScoreHistory::new(mission_of(&reader).unwrap().unwrap()).unwrap().unwrap();
    for step in reader.steps_between(Time::BEGINNING, Time::END).unwrap() {
        let step = step.unwrap();
        history.observe(0, &step.batch, &step.decoded_effects().unwrap());
    }
    let mut scores = BTreeSet::new();
    for at_ns in instants(&reader, count) {
        let shown = history.at(Time(at_ns)).unwrap();
        assert!(shown.counted_ns <= at_ns, "{shown:?} at {at_ns}");
        let counted = history.at(Time(shown.counted_ns)).unwrap();
        let report = report_until(&reader, &mission, Time(shown.counted_ns)).unwrap();
        let MissionValue::Score(score) = report.value else { panic!("a mission of fires has a score") };
        assert_eq!(counted.benefits, score.benefits, "at {at_ns}");
        assert!((counted.score - score.score).abs() < 1e-9, "{counted:?} at {at_ns}: {}", score.score);
        scores.insert(score.benefits.to_bits());
    }
    assert!(scores.len() > 3, "the score grows during a flight");
}

/// All answers about an instant, without how far the record has grown.
fn answers(record: &Path, agent: usize, at_ns: i64) -> Value {
    let mut view = RecordView::open(record, agent).unwrap();
    let mut mission = json!(view.mission(Some(at_ns)).unwrap());
    for grown in ["end_ns", "batches", "status", "record"] {
        mission.as_object_mut().unwrap().remove(grown);
    }
    let to_ns = Some(at_ns);
    let lanes = TimelineQuery { from_ns: Some(0), to_ns: Some(at_ns * 2), at_ns: to_ns, ..TimelineQuery::default() };
    json!({
        "mission": mission,
        "tasks": view.tasks(&everything_at(at_ns)).unwrap(),
        "timeline": view.timeline(&lanes).unwrap(),
        "targets": view.targets(to_ns).unwrap(),
        "events": view.events(&EventsQuery { to_ns, limit: Some(5_000), ..EventsQuery::default() }).unwrap(),
        "track": view.track(&TrackQuery { to_ns, ..TrackQuery::default() }).unwrap(),
        "report": view.report(to_ns).unwrap(),
        "plan": view.plan(to_ns).unwrap(),
        "plans": view.plans(to_ns).unwrap(),
        "commands": view.operator_commands(to_ns).unwrap(),
        "questions": view.questions(to_ns).unwrap(),
        "troubles": view.troubles(to_ns).unwrap(), // english: allow
    })
}

/// Returns the record as it would be if the flight had been cut off after `at_ns`.
fn cut_off(record: &Path, at_ns: i64) -> PathBuf {
    let cut = record.with_extension("cut");
    std::fs::copy(record, &cut).unwrap();
    let connection = rusqlite::Connection::open(&cut).unwrap();
    for table in ["batch", "note", "snapshot", "problem", "situation", "track", "target_state"] {
        connection.execute(&format!("DELETE FROM {table} WHERE t_ns > ?1"), [at_ns]).unwrap();
    }
    connection.execute("DELETE FROM answer WHERE due_ns > ?1", [at_ns]).unwrap();
    connection.execute("DELETE FROM effects WHERE batch NOT IN (SELECT id FROM batch)", []).unwrap();
    let end = "DELETE FROM report; DELETE FROM seal; \
        DELETE FROM meta WHERE key IN ('end_ns', 'end_reason') OR (key = 'complete' AND value = '1')";
    connection.execute_batch(end).unwrap();
    seal_rows(&connection).unwrap();
    cut
}

fn compare_with_cut(record: &Path, agent: usize, count: u64) {
    let reader = RecordReader::open(record).unwrap();
    let last = reader.span().unwrap().unwrap().1.0;
    for at_ns in instants(&reader, count).into_iter().filter(|&at_ns| at_ns < last) {
        let (whole, cut) = (answers(record, agent, at_ns), answers(&cut_off(record, at_ns), agent, at_ns));
        for (what, answer) in whole.as_object().unwrap() {
            assert_eq!(answer, &cut[what], "{what} at {at_ns} ns of {}", record.display());
        }
    }
}

#[test]
fn small_missions_show_what_was_known() {
    let folder = tempfile::tempdir().unwrap();
    for (name, agents) in [("first-picture", 1), ("structure-watch", 1), ("two-crew", 2)] {
        let record = flown(folder.path(), name, 2.0);
        for agent in 0..agents {
            compare_with_agent(&record, agent, 200);
            compare_with_cut(&record, agent, 20);
        }
    }
}

/// Compares the times of planned visits with the plan in the restored situation, and with the visits that were flown.
#[test]
fn visits_of_repeated_observations_are_planned_in_mission_time() {
    let folder = tempfile::tempdir().unwrap();
    let record = flown(folder.path(), "structure-watch", 0.5);
    let reader = RecordReader::open(&record).unwrap();
    let mission = mission_of(&reader).unwrap().unwrap();
    let mut view = RecordView::open(&record, 0).unwrap();
    let numbers: BTreeSet<i64> = instants(&reader, 40)
        .into_iter()
        .filter_map(|at_ns| {
            let shown = view.plan(Some(at_ns)).unwrap()?;
            let known = situation_at(&reader, &mission, Time(at_ns)).unwrap().plan?;
            let Plan::Surveillance(plan) = &known.plan else { panic!("the mission watches structures") };
            let begins: Vec<i64> = shown.visits.iter().map(|visit| visit.begin_ns).collect();
            let since = |visit: &SurveillanceVisit| Time::from_seconds(known.made.seconds() + visit.arrive_s).0;
            assert_eq!(begins, plan.visits.iter().map(since).collect::<Vec<_>>(), "at {at_ns} ns");
            assert!(begins.iter().all(|begin_ns| *begin_ns >= known.made.0), "at {at_ns} ns");
            Some(shown.number)
        })
        .collect();
    assert!(numbers.len() > 2, "several plans: {numbers:?}");
    // A target of the plan in force is planned, also if an earlier plan left it out.
    let plan = view.plan(None).unwrap().unwrap();
    for target in view.targets(None).unwrap().targets {
        let ahead = plan.visits.iter().any(|visit| visit.target == target.id);
        let since_plan = target.history.iter().filter(|change| change.t_ns >= plan.adopted_ns).count();
        if ahead && since_plan == 1 {
            assert_eq!(target.state.as_deref(), Some("planned"), "{}", target.id);
        }
        assert!(!ahead || target.state.as_deref() != Some("skipped"), "{} is planned and left out", target.id);
    }
}

#[test]
fn targets_have_the_values_and_observations_of_the_instant() {
    let folder = tempfile::tempdir().unwrap();
    let record = flown(folder.path(), "structure-watch", 2.0);
    let mut view = RecordView::open(&record, 0).unwrap();
    let minutes = |minutes: i64| Some(minutes * 60_000_000_000);
    let mut target = |id: &str, at_ns| {
        let targets = view.targets(at_ns).unwrap().targets;
        targets.into_iter().find(|target| target.id == id).unwrap()
    };
    // The scenario re-values the winery at 20 min, and drops the eastern cabin at 15 min.
    assert_eq!([19, 20, 50].map(|at| target("winery", minutes(at)).value), [Some(150.0), Some(300.0), Some(300.0)]);
    let cabin = target("cabin-east", minutes(50));
    assert_eq!((cabin.since_ns, cabin.detail.as_deref()), (minutes(15), Some("no longer a target")));
    // The barn is seen after four minutes; plans from 11 min on leave it out.
    let barn = [4, 5, 50].map(|at| target("barn", minutes(at)));
    assert_eq!(barn.each_ref().map(|barn| barn.observed_ns.is_some()), [false, true, true]);
    assert_eq!(barn[2].state.as_deref(), Some("skipped"));
    // The report, which is made of the steps alone, counts the same observations.
    let end = view.mission(None).unwrap();
    let report = view.report(None).unwrap();
    let score = report.sections.iter().find(|section| section.section == "score").unwrap();
    let seen = score.body["pictures"].as_array().unwrap().iter().filter(|one| one["seen"].as_u64() > Some(0)).count();
    assert_eq!((end.observed, end.targets, end.score_kind.as_deref()), (seen, 17, Some("expected-cost-of-ignorance")));
    assert!(seen > 5, "{seen}");
}

/// Changes of a record that follow from its mission; each is sealed again, so that only replay can tell.
const FORGERIES: [&str; 7] = [
    "UPDATE target SET value = value + 1",
    "UPDATE target SET latitude_deg = latitude_deg + 1, name = 'elsewhere' WHERE position = 1",
    "DELETE FROM target WHERE position = (SELECT max(position) FROM target)",
    "DELETE FROM report",
    "UPDATE meta SET value = 'another' WHERE key = 'mission'",
    "UPDATE meta SET value = 'another' WHERE key = 'vehicle'",
    "UPDATE meta SET value = '2001-01-01T00:00:00Z' WHERE key = 'epoch_utc'",
];

/// An instant of the civil day for a mission that has none.
const EPOCH_ADDED: &str = "INSERT INTO meta (key, value) VALUES ('epoch_utc', '1999-01-01T00:00:00Z')";

#[test]
fn replay_compares_what_follows_from_the_mission() {
    let folder = tempfile::tempdir().unwrap();
    let [with_epoch, without] = ["stand-off", "first-picture"].map(|mission| flown(folder.path(), mission, 0.1));
    let replayed = |record: &Path| replay(&RecordReader::open(record).unwrap()).unwrap().difference;
    assert_eq!([&with_epoch, &without].map(|record| replayed(record)), [None, None]);
    let forgeries = FORGERIES.map(|forgery| (&with_epoch, forgery));
    for (record, forgery) in forgeries.into_iter().chain([(&without, EPOCH_ADDED)]) {
        let forged = folder.path().join("forged.apex");
        std::fs::copy(record, &forged).unwrap();
        let connection = rusqlite::Connection::open(&forged).unwrap();
        connection.execute_batch(&format!("{forgery}; DELETE FROM seal")).unwrap();
        seal_rows(&connection).unwrap();
        drop(connection);
        assert!(replayed(&forged).is_some(), "replay confirms: {forgery}");
    }
}

#[test]
fn longer_missions_show_what_was_known() {
    let folder = tempfile::tempdir().unwrap();
    for (name, hours) in [("day-and-night", 0.5), ("diagnosis", 0.5), ("pipeline-inspection", 0.5), ("stand-off", 0.5)]
    {
        let record = flown(folder.path(), name, hours);
        compare_with_agent(&record, 0, 50);
        compare_with_cut(&record, 0, 3);
    }
}

#[test]
fn western_states_shows_what_was_known() {
    let folder = tempfile::tempdir().unwrap();
    let record = flown(folder.path(), "western-states", 5.5);
    compare_with_agent(&record, 0, 200);
    compare_with_cut(&record, 0, 8);
    compare_score(&record, 10);
    let mut view = RecordView::open(&record, 0).unwrap();
    let known = |view: &mut RecordView, hours: i64| {
        let targets = view.targets(Some(hours * 3_600_000_000_000)).unwrap().targets;
        let mut late: Vec<String> =
            targets.iter().filter(|one| one.announced_ns.is_some()).map(|one| one.id.clone()).collect();
        late.sort_unstable();
        (targets.len(), late)
    };
    assert_eq!(known(&mut view, 0), (22, vec![]));
    assert_eq!(known(&mut view, 3), (23, vec!["domke-lake".into()]));
    assert_eq!(known(&mut view, 5), (24, vec!["castle-rock".into(), "domke-lake".into()]));
    let start = view.mission(Some(0)).unwrap();
    assert_eq!((start.score, start.ending, start.targets, start.observed), (None, None, 22, 0));
    assert!(view.mission(None).unwrap().score.is_some());
}
