//! Tests of live sources: the order in which they are served, the reports, and readers that wait instead of losing commands.

use super::*;
use apex_model::event::StateVariable;
use apex_model::symbol::Symbol;
use std::sync::atomic::{AtomicUsize, Ordering};

fn sources() -> (LiveSources, Arc<AtomicUsize>) {
    let woken = Arc::new(AtomicUsize::new(0));
    let counted = Arc::clone(&woken);
    (LiveSources::new(move || _ = counted.fetch_add(1, Ordering::SeqCst)), woken)
}

fn introduced(sources: &LiveSources, name: &str, class: SourceClass) -> LiveSource {
    let source = sources.admit(class).unwrap();
    source.introduce(&Introduction { name: name.into(), class }).unwrap();
    source
}

fn command(text: &str) -> LiveInput {
    LiveInput::Event(None, EventKind::Occurrence(Value::list([Value::symbol(text)])))
}

fn measurement(name: &str, value: i64) -> LiveInput {
    let variable = StateVariable::new(Symbol::new("height"), Value::symbol(name));
    LiveInput::Event(None, EventKind::Measurement(variable, Value::Integer(value)))
}

/// Returns the inputs that are taken, as text, without reports of introductions.
fn taken(sources: &LiveSources) -> Vec<String> {
    let text = |control: LiveInput| match control {
        LiveInput::Event(None, EventKind::Occurrence(form)) => form.to_string(),
        LiveInput::Event(None, EventKind::Measurement(variable, value)) => format!("{variable} {value}"),
        other => format!("{other:?}"),
    };
    sources.take().into_iter().map(text).filter(|text| !text.contains("connected")).collect()
}

#[test]
fn operators_and_safing_are_heard_before_vehicles_and_those_before_feeds() {
    let (sources, _) = sources();
    let (feed, vehicle) =
        (introduced(&sources, "wx", SourceClass::Feed), introduced(&sources, "uav", SourceClass::Vehicle));
    let (safing, tower) =
        (introduced(&sources, "failsafe", SourceClass::Safing), introduced(&sources, "tower", SourceClass::Operator));
    for (source, word) in [(&feed, "f"), (&vehicle, "v"), (&safing, "s"), (&tower, "o")] {
        assert!(source.say([command(word), measurement(word, 1)]));
    }
    let first = taken(&sources);
    assert_eq!(
        first,
        ["(live-source failsafe says)", "(s)", "(live-source tower says)", "(o)", "(height s) 1", "(height o) 1"]
    );
    assert_eq!(taken(&sources), ["(live-source uav says)", "(v)", "(height v) 1"]);
    std::thread::sleep(LIVE_REST);
    assert_eq!(taken(&sources), ["(live-source wx says)", "(f)", "(height f) 1"]);
    assert!(taken(&sources).is_empty() && !sources.has_waiting() && sources.ready_in().is_none());
}

#[test]
fn sources_of_a_class_are_heard_in_turn_and_a_step_is_short() {
    let (sources, _) = sources();
    let (flood, quiet) = (sources.admit(SourceClass::Feed).unwrap(), sources.admit(SourceClass::Feed).unwrap());
    assert!(flood.say((0..900).map(|_| command("flood"))));
    assert!(quiet.say([command("quiet")]));
    let first = taken(&sources);
    assert!(first.iter().take(2).any(|text| text == "(quiet)"), "{first:?}");
    assert!(first.len() <= 201, "a burst of a feed is 200 inputs: {}", first.len());
    let ready = sources.ready_in().unwrap();
    assert!(ready > Duration::ZERO && ready <= Duration::from_millis(5), "{ready:?}");
}

#[test]
fn what_is_lost_is_named_once_a_second_and_nothing_of_commands_is() {
    let (sources, _) = sources();
    let uav = introduced(&sources, "uav", SourceClass::Vehicle);
    assert!(uav.say((0..5_000).map(|value| measurement("a", value))));
    uav.not_understood(7);
    let report = ["(live-source uav lost 4999 (height a))", "(live-source uav not-understood 7)", "(height a) 4999"];
    assert_eq!(taken(&sources), report);
    assert!(uav.say((0..10).map(|value| measurement("a", value))));
    std::thread::sleep(LIVE_REST);
    assert_eq!(taken(&sources), ["(height a) 9"], "the next report comes a second later");
    drop(uav);
    assert_eq!(taken(&sources), ["(live-source uav lost 9 (height a))"]);
    assert_eq!(taken(&sources), ["(live-source uav gone)"]);
}

#[test]
fn a_reader_with_too_many_commands_waits_until_they_are_taken() {
    let (sources, woken) = sources();
    let feed = sources.admit(SourceClass::Operator).unwrap();
    let reader = std::thread::spawn(move || feed.say((0..2_500).map(|number| command(&format!("c{number}")))));
    let mut heard = Vec::new();
    while heard.len() < 2_500 {
        heard.extend(taken(&sources));
        std::thread::yield_now();
    }
    assert!(reader.join().unwrap());
    assert!(heard.iter().enumerate().all(|(number, text)| *text == format!("(c{number})")));
    assert!(woken.load(Ordering::SeqCst) >= 1);
    let late = sources.admit(SourceClass::Operator).unwrap();
    sources.close();
    assert!(!late.say([command("late")]), "the run is over");
}

#[test]
fn names_are_unique_and_floods_of_connections_keep_no_operator_out() {
    let (sources, _) = sources();
    let nav = introduced(&sources, "nav", SourceClass::Vehicle);
    let feeds: Vec<LiveSource> = (1..LIVE_SOURCES_MAX).map(|_| sources.admit(SourceClass::Feed).unwrap()).collect();
    assert!(sources.admit(SourceClass::Feed).err().unwrap().contains("which is the limit"));
    let tower = sources.admit(SourceClass::Operator).unwrap();
    let same = Introduction { name: "NAV".into(), class: SourceClass::Operator };
    assert!(tower.introduce(&same).unwrap_err().contains("another source is called NAV"));
    drop(nav);
    tower.introduce(&same).unwrap();
    assert_eq!(tower.name().as_deref(), Some("NAV"));
    drop(feeds);
    sources.take();
    assert!(sources.admit(SourceClass::Feed).is_ok());
}

#[test]
fn a_source_keeps_its_name_and_class() {
    let (sources, _) = sources();
    let nav = introduced(&sources, "nav", SourceClass::Vehicle);
    sources.take();
    for (name, class) in
        [("tower", SourceClass::Operator), ("nav", SourceClass::Operator), ("uav", SourceClass::Vehicle)]
    {
        let refusal = nav.introduce(&Introduction { name: name.into(), class }).unwrap_err();
        assert!(
            refusal.contains("has introduced itself as nav of class vehicle; open another connection"),
            "{refusal}"
        );
    }
    assert_eq!((nav.name().as_deref(), nav.stated_class()), (Some("nav"), Some(SourceClass::Vehicle)));
    nav.introduce(&Introduction { name: "Nav".into(), class: SourceClass::Vehicle }).unwrap();
    assert!(sources.take().is_empty(), "nothing new is reported");
}

#[test]
fn a_flight_that_waits_is_woken_once() {
    let (sources, woken) = sources();
    let tower = sources.admit(SourceClass::Operator).unwrap();
    assert_eq!(sources.ready_in(), None);
    (0..5).for_each(|_| _ = tower.say([command("a")]));
    assert_eq!(woken.load(Ordering::SeqCst), 1, "it looks already");
    assert_eq!(sources.ready_in(), Some(Duration::ZERO));
    assert_eq!(sources.take().len(), 5);
    assert_eq!(sources.ready_in(), None);
    tower.say([command("b")]);
    assert_eq!(woken.load(Ordering::SeqCst), 2);
}
