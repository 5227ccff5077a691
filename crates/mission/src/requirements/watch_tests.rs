//! Tests of the watcher: reported margins, and requirements that cannot be judged.

use super::*;
use crate::link::LinkMemory;
use crate::storm::StormMemory;
use apex_model::because::{Because, Cause};
use apex_model::effect::CommandId;
use apex_model::event::Event;
use apex_model::planned::Location;
use apex_model::task::TaskId;

#[test]
fn margins_are_reported_with_three_digits() {
    assert_eq!(rounded(12_345.6), 12_300.0);
    assert_eq!(rounded(-0.012_345), -0.0123);
    assert_eq!((rounded(0.0), rounded(f64::INFINITY)), (0.0, f64::INFINITY));
}

/// A watcher of a flight of western-states.
struct Watched {
    mission: Mission,
    air: AirState,
    watch: Watch,
}

impl Watched {
    fn new() -> Watched {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../missions/western-states");
        let mut mission = Mission::load(&path).unwrap_or_else(|error| panic!("{error:?}"));
        mission.requirements.terrain_clearance_m = Some(300.0);
        let mut air = AirState::default();
        air.hear(&EventKind::Occurrence(Value::list([Value::symbol("airborne"), Value::symbol("uav")])));
        Watched { mission, air, watch: Watch::default() }
    }

    /// Shows a step with these samples of the vehicle and these effects.
    fn step(&mut self, at_s: f64, samples: &[(&str, Value)], effects: &[Effect]) -> Findings {
        let (now, vehicle) = (Time::from_seconds(at_s), Value::Symbol(self.mission.agent.name.clone()));
        let of = |(attribute, value): &(&str, Value)| {
            let variable = StateVariable::new(Symbol::new(attribute), vehicle.clone());
            Event { sequence: 0, at: now, kind: EventKind::Measurement(variable, value.clone()) }
        };
        let batch = Batch { now, events: samples.iter().map(of).collect() };
        let (links, storms) = (LinkMemory::default(), StormMemory::default());
        let known = (&self.mission, &self.mission.weather, &links, &storms);
        self.watch.observe(known, &self.air, &batch, effects)
    }
}

fn place(latitude_deg: f64) -> (&'static str, Value) {
    let position = apex_model::problem::Position::new(latitude_deg, -118.0);
    ("location", Location { position, altitude_m: 6_000.0 }.value())
}

/// Returns the reported states of a requirement.
fn states(findings: &Findings, requirement: &str) -> Vec<String> {
    let of = |input: &Input| match &input.kind {
        EventKind::Measurement(variable, value)
            if variable.attribute.is("requirement-state") && variable.object == Value::symbol(requirement) =>
        {
            Some(value.to_string())
        }
        _ => None,
    };
    findings.inputs.iter().filter_map(of).collect()
}

#[test]
fn a_requirement_without_the_reports_that_it_needs_is_unknown_and_noted_once() {
    let mut watched = Watched::new();
    let first = watched.step(0.0, &[place(35.0)], &[]);
    assert_eq!((states(&first, "energy"), states(&first, "terrain")), (vec!["unknown".into()], vec!["unknown".into()]));
    let notes = |findings: &Findings| findings.notes.iter().filter(|note| note.contains("is not judged")).count();
    assert_eq!(notes(&first), 2, "{:?}", first.notes);
    assert!(first.notes[0].contains("`height-above-ground`"), "{:?}", first.notes);
    // It is repeated like every state, without a note.
    let mut again = Vec::new();
    for at_s in 1..=7 {
        let findings = watched.step(f64::from(at_s) * 10.0, &[place(35.0 + 0.01 * f64::from(at_s))], &[]);
        assert_eq!(notes(&findings), 0);
        again.extend(states(&findings, "energy"));
    }
    assert_eq!(again, ["unknown"]);
    // With the reports it is judged at once.
    let endurance = Value::Duration(Duration::from_seconds(36_000.0));
    let height = Value::measured(4_000.0, Dimension::LENGTH);
    let samples = [place(35.08), ("endurance-remaining", endurance), ("height-above-ground", height)];
    let judged = watched.step(80.0, &samples, &[]);
    assert_eq!((states(&judged, "energy"), states(&judged, "terrain")), (vec!["kept".into()], vec!["kept".into()]));
}

#[test]
fn no_requirement_is_judged_after_a_minute_without_a_position() {
    let mut watched = Watched::new();
    let endurance = ("endurance-remaining", Value::Duration(Duration::from_seconds(36_000.0)));
    assert_eq!(states(&watched.step(0.0, &[place(35.0), endurance], &[]), "energy"), ["kept"]);
    assert_eq!(states(&watched.step(55.0, &[], &[]), "energy"), Vec::<String>::new());
    assert_eq!(states(&watched.step(61.0, &[], &[]), "energy"), ["unknown"]);
    assert_eq!(states(&watched.step(70.0, &[], &[]), "energy"), Vec::<String>::new());
    assert_eq!(states(&watched.step(71.0, &[place(35.1)], &[]), "energy"), ["kept"]);
}

#[test]
fn a_commanded_landing_is_reported_for_a_vehicle_without_a_flight_phase() {
    let command = |number: u64, form: &str| Effect::Command {
        command: CommandId(number),
        task: TaskId(1),
        form: apex_pdl::read_value(form).unwrap_or_else(|error| panic!("{error:?}")),
        because: Because::new(Cause::InitialTask, None),
    };
    let said = |findings: Findings| {
        let of = |input: Input| match input.kind {
            EventKind::Measurement(variable, value) if variable.attribute.is("landing-commanded") => {
                Some(value.to_string())
            }
            _ => None,
        };
        findings.inputs.into_iter().filter_map(of).collect::<Vec<_>>()
    };
    let mut watched = Watched::new();
    assert_eq!(said(watched.step(0.0, &[place(35.0)], &[])), Vec::<String>::new());
    assert_eq!(said(watched.step(1.0, &[], &[command(1, "(land (35.1 -118.0))")])), ["t"]);
    assert_eq!(said(watched.step(2.0, &[], &[])), Vec::<String>::new());
    assert_eq!(said(watched.step(3.0, &[], &[command(2, "(fly-to (36.0 -118.0 7000.0))")])), ["nil"]);
    // A reported phase says more.
    let phase = ("flight-phase", Value::symbol("cruising"));
    let mut reporting = Watched::new();
    assert_eq!(said(reporting.step(0.0, &[place(35.0), phase], &[])), Vec::<String>::new());
    assert_eq!(said(reporting.step(1.0, &[], &[command(1, "(land (35.1 -118.0))")])), Vec::<String>::new());
}
