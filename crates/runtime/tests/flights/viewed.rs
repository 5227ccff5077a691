//! Answers of the record view: questions at an instant, searches in several answers, commands of operators.

use crate::support::{event, load, program, record};
use apex_model::effect::QuestionId;
use apex_model::event::EventKind;
use apex_model::time::Time;
use apex_model::value::Value;
use apex_runtime::mission_loop::RunSettings;
use apex_runtime::ports::Input;
use apex_runtime::program::{NoDeliberator, run_with};
use apex_runtime::record::view::{EventsQuery, QuestionEnd, RecordView, TasksQuery, TroubleKind};
use apex_runtime::record::{RecordOptions, Recorder, TargetRow};

const ASKING: &str = r#"
(procedure (index (do-domain))
  (step first (ask operator "Continue?" :options (yes no) :by 30s :default no))
  (step second (ask operator "Which way?" :by 10s :default (left)) (waitfor (end ?first)))
  (step rest (rest) (waitfor (end ?second)))
  (step done (end-application) (waitfor ?rest)))
(primitive (index (rest)) (duration 100s))
"#;

fn answer(seconds: f64, question: u64, value: &str) -> Input {
    Input::new(Time::from_seconds(seconds), EventKind::OperatorAnswered(QuestionId(question), Value::symbol(value)))
}

#[test]
fn questions_are_open_from_their_effect_until_they_are_answered_or_withdrawn() {
    let flight = record(ASKING, vec![answer(5.0, 0, "yes")], &mut NoDeliberator, &mut []);
    let view = RecordView::open(&flight.path, 0).unwrap();
    let program = flight.reader().load(&load).unwrap();
    let shown = |seconds: f64| view.questions(Some(Time::from_seconds(seconds).0)).unwrap().questions;
    for seconds in [0.0, 4.9, 5.0, 9.0, 14.9, 15.0, 50.0] {
        let restored = flight.reader().restore_with(Time::from_seconds(seconds), &program).unwrap();
        let known: Vec<u64> = restored.questions.keys().map(|question| question.0).collect();
        let open =
            shown(seconds).iter().filter(|one| one.closed_ns.is_none()).map(|one| one.question).collect::<Vec<_>>();
        assert_eq!(open, known, "{seconds} s");
    }
    let [first] = shown(4.0).try_into().unwrap();
    assert_eq!((first.text.as_str(), first.options.join(" ")), ("Continue?", "yes no".to_owned()));
    assert_eq!((first.by_ns, first.default.as_deref()), (Some(30_000_000_000), Some("no")));
    let [first, second] = shown(50.0).try_into().unwrap();
    let answered = QuestionEnd::Answered { answer: "yes".into(), author: None };
    assert_eq!((first.closed_ns, first.ended), (Some(5_000_000_000), Some(answered)));
    let default = QuestionEnd::Default { answer: "(left)".into() };
    assert_eq!((second.asked_ns, second.closed_ns), (5_000_000_000, Some(15_000_000_000)));
    assert_eq!(second.ended, Some(default));
    // What happens later is not known.
    assert_eq!(shown(6.0).last().map(|one| (one.closed_ns, one.ended.clone())), Some((None, None)));
}

#[test]
fn a_question_states_its_answerer_and_why_others_were_withdrawn() {
    let asking = r#"
(procedure (index (do-domain))
  (step first (ask operator "Continue?" :options (yes no)))
  (step mute (ask operator "Which way?" :by 10s))
  (step cut (ask operator "How far?")))
"#;
    // The run records a command and its answer at one instant; another command of this instant has another author.
    let entry = |number: u32, rest: &str| event(5.0, &format!("(operator-command {number} \"x\" accepted {rest})"));
    let inputs = vec![
        entry(1, ":by \"bob\""),
        entry(2, ":by \"ann\" :epoch 1 :answers 0"),
        answer(5.0, 0, "yes"),
        entry(3, ":by \"cleo\" :answers 1"),
    ];
    let flight = record(asking, inputs, &mut NoDeliberator, &mut []);
    let view = RecordView::open(&flight.path, 0).unwrap();
    let ends: Vec<_> = view.questions(None).unwrap().questions.into_iter().map(|asked| asked.ended).collect();
    let withdrawn = |reason: &str| Some(QuestionEnd::Withdrawn { reason: reason.into() });
    let answered = QuestionEnd::Answered { answer: "yes".into(), author: Some("ann".into()) };
    assert_eq!(ends, [Some(answered), withdrawn("the operator's time is over"), withdrawn("its task ended")]);
}

/// A handled failure is stated by its parts, not only by its message.
#[test]
fn a_handled_failure_names_the_subtask_and_its_handler() {
    let pdl = r#"
(procedure :sequential (index (do-domain))
  (step a (see zaca))
  (step b (print "over")))
(procedure (index (see ?site))
  (step look (look at (site ?site)) (on-failure (leave ?site))))
(procedure (index (look at (?or (site ?name) ?loc)))
  (step say (print "looking at" ?loc)))
(procedure (index (leave ?site)) (step say (print "leaving" ?site)))
"#;
    let flight = record(pdl, vec![], &mut NoDeliberator, &mut []);
    let mut view = RecordView::open(&flight.path, 0).unwrap();
    let entries = view.troubles(None).unwrap().troubles; // english: allow
    let of = |kind: TroubleKind| entries.iter().filter(|entry| entry.kind == kind).collect::<Vec<_>>();
    let (failed, faults) = (of(TroubleKind::Failed), of(TroubleKind::Fault));
    let ([failed], [fault]) = (failed.as_slice(), faults.as_slice()) else { panic!("{entries:?}") };
    assert_eq!((fault.failed_child, fault.handler.as_deref()), (failed.task, Some("(leave zaca)")));
    assert!(fault.subject.contains("failed: an expression failed"), "{fault:?}");
    assert_eq!((failed.failed_child, failed.handler.as_deref()), (None, None));
    assert!(fault.place.is_some() && failed.place.is_some(), "{entries:?}");
}

const VISITING: &str = r#"
(procedure (index (do-domain))
  (step visit (visit zaca :from (places lick)) (priority 3))
  (step call (inform (visiting zaca)))
  (step urgent (rest) (waitfor (urgent)) (priority 7))
  (step done (end-application) (waitfor ?urgent)))
(primitive (index (visit ?target :from ?places)) (profile flight-path) (duration 100s))
(primitive (index (rest)) (profile flight-path) (duration 5s))
"#;

/// Records the targets of a mission; it has no states of them.
fn record_targets(inputs: Vec<Input>) -> (tempfile::TempDir, std::path::PathBuf) {
    let folder = tempfile::TempDir::new().unwrap();
    let path = folder.path().join("flight.apex");
    let (library, declaration, host) = program(VISITING);
    let mut recorder = Recorder::create(&path, &library, RecordOptions::default()).unwrap();
    recorder.program(&library).unwrap();
    for id in ["Zaca", "lick", "barn"] {
        recorder.target(&TargetRow { id: id.into(), ..TargetRow::default() }).unwrap();
    }
    let mut agent = apex_executive::load(library, &declaration, host).unwrap();
    let options = RunSettings { inputs, ..RunSettings::default() };
    let end = run_with(&mut agent, &mut NoDeliberator, &mut [&mut recorder], options).unwrap();
    recorder.finish(end.at, &end.reason.text()).unwrap();
    (folder, path)
}

#[test]
fn tasks_and_interruptions_state_the_targets_of_their_goals() {
    let (_folder, path) = record_targets(vec![event(10.0, "(urgent)")]);
    let mut view = RecordView::open(&path, 0).unwrap();
    let tasks = view.tasks(&TasksQuery { at_ns: Some(5_000_000_000), ..TasksQuery::default() }).unwrap().tasks;
    let of = |tag: &str| tasks.iter().find(|task| task.tag == tag).unwrap();
    assert_eq!(
        (of("visit").targets.as_slice(), of("visit").is_message),
        (["Zaca", "lick"].map(String::from).as_slice(), false)
    );
    assert_eq!((of("call").targets.as_slice(), of("call").is_message), (["Zaca".to_string()].as_slice(), true));
    assert!(of("urgent").targets.is_empty());
    let entries = view.troubles(None).unwrap().troubles; // english: allow
    let [interrupted] = entries.as_slice() else { panic!("{entries:?}") };
    assert_eq!(interrupted.targets, ["Zaca", "lick"]);
    assert_eq!(interrupted.cause_kind.as_deref(), Some("outranked"));
}

#[test]
fn a_target_is_gone_from_its_message_until_it_is_announced_again() {
    let inputs = vec![
        event(2.0, "(target-gone zaca)"),
        event(4.0, "(target-gone zaca)"),
        event(6.0, "(new-target zaca)"),
        event(10.0, "(urgent)"),
    ];
    let (_folder, path) = record_targets(inputs);
    let mut view = RecordView::open(&path, 0).unwrap();
    let mut gone = |at_s: i64| {
        let targets = view.targets(Some(at_s * 1_000_000_000)).unwrap().targets;
        targets.into_iter().find(|target| target.id == "Zaca").unwrap().gone_ns
    };
    assert_eq!([1, 2, 5, 6].map(&mut gone), [None, Some(2_000_000_000), Some(2_000_000_000), None]);
}

const TICKING: &str = r#"
(procedure (index (do-domain))
  (step tick (print "tick") (waitfor (tick)) (repeating))
  (step needle (print "needle") (waitfor (needle)))
  (step done (end-application) (waitfor (enough))))
"#;

#[test]
fn a_search_in_several_answers_finds_what_one_answer_finds() {
    let mut inputs: Vec<Input> = (1..=60).map(|second| event(f64::from(second), "(tick)")).collect();
    inputs.extend([event(20.5, "(needle)"), event(61.0, "(enough)")]);
    let flight = record(TICKING, inputs, &mut NoDeliberator, &mut []);
    let ask = |find: &str, searched_max: Option<usize>| {
        // A new view has no index yet; with an index the blocks that may match are searched.
        let view = RecordView::open(&flight.path, 0).unwrap();
        let find = Some(find.to_owned());
        let mut query = EventsQuery { find, searched_max, limit: Some(5_000), ..EventsQuery::default() };
        let (mut found, mut answers) = (Vec::new(), 0);
        loop {
            let part = view.events(&query).unwrap();
            assert_eq!(part.next.is_some(), part.more, "a search that has ended leaves nothing out");
            found.splice(0..0, part.events.iter().map(|event| event.id));
            answers += 1;
            match part.next {
                Some(next) => query.before = Some(next),
                None => return (found, answers),
            }
        }
    };
    for find in ["needle", "tick", "nowhere", "has this step"] {
        let (whole, one) = ask(find, None);
        assert_eq!(one, 1);
        for searched_max in [1, 7, 50] {
            assert_eq!(ask(find, Some(searched_max)).0, whole, "{find} by {searched_max}");
        }
        assert_eq!(whole.is_empty(), find == "nowhere");
    }
    assert!(ask("needle", Some(7)).1 > 1);
    // Numbers that no effect has.
    let view = RecordView::open(&flight.path, 0).unwrap();
    let before = |number| EventsQuery {
        before: Some(number),
        find: Some("tick".into()),
        limit: Some(5_000),
        ..EventsQuery::default()
    };
    let counts = [i64::MIN, 0, 1, i64::MAX].map(|number| view.events(&before(number)).unwrap().events.len());
    assert_eq!(counts, [0, 0, 0, ask("tick", None).0.len()]);
}

/// While a thread indexes the log, each answer reads fewer effects, so that ten searches at once do not delay each other for long.
#[test]
fn a_search_in_a_log_that_is_being_indexed_is_answered_in_smaller_parts() {
    let mut inputs: Vec<Input> = (1..=200).map(|second| event(f64::from(second), "(tick)")).collect();
    inputs.push(event(201.0, "(enough)"));
    let flight = record(TICKING, inputs, &mut NoDeliberator, &mut []);
    let view = RecordView::open(&flight.path, 0).unwrap();
    let mut query = EventsQuery { find: Some("nowhere".into()), ..EventsQuery::default() };
    assert!(!view.index_effects(std::time::Duration::ZERO).unwrap(), "a thread has begun to index");
    let mut parts = 1;
    while let Some(next) = view.events(&query).unwrap().next {
        (query.before, parts) = (Some(next), parts + 1);
    }
    assert_eq!(parts, 2);
    while !view.index_effects(std::time::Duration::from_secs(1)).unwrap() {}
    assert_eq!(view.events(&EventsQuery { before: None, ..query }).unwrap().next, None);
}

#[test]
fn commands_of_operators_are_those_settled_by_the_instant() {
    let command = |seconds: f64, number: u32| {
        event(seconds, &format!("(operator-command {number} \"remark {number}\" accepted)"))
    };
    let inputs = vec![
        command(3.0, 1),
        command(8.0, 2),
        event(9.0, "(operator-commander 3 \"no\" accepted)"),
        event(20.0, "(enough)"),
    ];
    let flight = record(TICKING, inputs, &mut NoDeliberator, &mut []);
    let view = RecordView::open(&flight.path, 0).unwrap();
    let by = |seconds: f64| {
        let commands = view.operator_commands(Some(Time::from_seconds(seconds).0)).unwrap().commands;
        commands.into_iter().map(|command| command.number).collect::<Vec<_>>()
    };
    assert_eq!([by(2.9), by(3.0), by(8.0), by(20.0)], [vec![], vec![1], vec![1, 2], vec![1, 2]]);
}
