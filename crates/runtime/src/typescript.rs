//! The page's TypeScript types, generated from the record view and the explainer. `UPDATE=1 cargo test -p apex-runtime
//! typescript` rewrites them.

use crate::explain::{
    About, Binding, Blocked, CauseDetail, CausePart, Choice, Link, MethodDetail, Moment, MonitoredCondition, Monitors,
    Observation, PartValue, Subtask, TaskExplanation, TaskMonitor, Unmet, Why,
};
use crate::record::view::{
    Band, Bar, DeclaredName, Ending, EventRow, Events, Excursion, Growth, Holding, Holdings, LandingPlace, Lane,
    LeftOutTarget, Mission, More, PlanInForce, PlannedVisit, Plans, ProcedureRow, ProgramContents, ProgramFile,
    ProgramText, RecordStatus, RecordedCommand, RecordedCommands, Report, ResourceRow, Section, Signal, SignalKind,
    SignalLimit, SignalWindow, SignalWindows, Signals, Snippet, StateWord, Statistics, StepRow, Surroundings, Target,
    TargetChange, Targets, Task, Tasks, Timeline, Track, Trouble, TroubleKind, Troubles, Zone,
};
use std::path::Path;
use ts_rs::{Config, TS};

/// Returns the configuration in which whole numbers are numbers: nanoseconds of mission time stay below 2^53 for a hundred days.
fn config() -> Config {
    Config::default().with_large_int("number")
}

/// Returns `export type ..` with its documentation.
fn declaration<T: TS>() -> String {
    format!("{}export {}\n", T::docs().unwrap_or_default(), T::decl(&config()))
}

fn check(file: &str, imports: &str, declarations: &[String]) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../web/src/record/generated").join(file);
    let header = "// Generated from crates/runtime by `UPDATE=1 cargo test -p apex-runtime typescript`. Do not edit.\n";
    let text = format!("{header}{imports}\n{}", declarations.join("\n"));
    if std::env::var_os("UPDATE").is_some() {
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, &text).unwrap();
    }
    let found = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        found == text,
        "{} differs from the types in Rust; run `UPDATE=1 cargo test -p apex-runtime typescript`",
        path.display()
    );
}

#[test]
fn typescript_types_of_the_record_view_are_current() {
    let declarations = [
        declaration::<StateWord>(),
        declaration::<RecordStatus>(),
        declaration::<Growth>(),
        declaration::<Ending>(),
        declaration::<Mission>(),
        declaration::<Track>(),
        declaration::<Task>(),
        declaration::<Tasks>(),
        declaration::<Bar>(),
        declaration::<Band>(),
        declaration::<Lane>(),
        declaration::<More>(),
        declaration::<Timeline>(),
        declaration::<EventRow>(),
        declaration::<Events>(),
        declaration::<TargetChange>(),
        declaration::<Target>(),
        declaration::<Targets>(),
        declaration::<PlannedVisit>(),
        declaration::<LeftOutTarget>(),
        declaration::<PlanInForce>(),
        declaration::<Plans>(),
        declaration::<Holding>(),
        declaration::<ResourceRow>(),
        declaration::<Holdings>(),
        declaration::<TroubleKind>(),
        declaration::<Trouble>(),
        declaration::<Troubles>(),
        declaration::<Zone>(),
        declaration::<LandingPlace>(),
        declaration::<Surroundings>(),
        declaration::<Section>(),
        declaration::<Report>(),
        declaration::<Snippet>(),
        declaration::<SignalKind>(),
        declaration::<SignalLimit>(),
        declaration::<Signal>(),
        declaration::<Signals>(),
        declaration::<Excursion>(),
        declaration::<Statistics>(),
        declaration::<SignalWindow>(),
        declaration::<SignalWindows>(),
        declaration::<RecordedCommand>(),
        declaration::<RecordedCommands>(),
        declaration::<StepRow>(),
        declaration::<ProcedureRow>(),
        declaration::<DeclaredName>(),
        declaration::<ProgramFile>(),
        declaration::<ProgramContents>(),
        declaration::<ProgramText>(),
    ];
    check("view.ts", "", &declarations);
}

#[test]
fn typescript_types_of_explanations_are_current() {
    let declarations = [
        declaration::<TaskExplanation>(),
        declaration::<Why>(),
        declaration::<About>(),
        declaration::<Link>(),
        declaration::<Moment>(),
        declaration::<MethodDetail>(),
        declaration::<CauseDetail>(),
        declaration::<CausePart>(),
        declaration::<PartValue>(),
        declaration::<Observation>(),
        declaration::<Choice>(),
        declaration::<Unmet>(),
        declaration::<Blocked>(),
        declaration::<Subtask>(),
        declaration::<Binding>(),
        declaration::<MonitoredCondition>(),
        declaration::<TaskMonitor>(),
        declaration::<Monitors>(),
    ];
    check("explain.ts", "\nimport type { Task } from './view';\n", &declarations);
}
