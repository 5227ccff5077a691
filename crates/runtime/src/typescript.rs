//! The page's TypeScript types, generated from the record view and the explainer. `UPDATE=1 cargo test -p apex-runtime
//! typescript` rewrites them.

use crate::explain::{
    About, Binding, Blocked, CauseDetail, CausePart, Choice, Link, MethodDetail, Moment, MonitoredCondition, Monitors,
    Observation, PartValue, Subtask, TaskExplanation, TaskMonitor, Unmet, Why,
};
use crate::record::view::{
    AskedQuestion, Band, DeclaredName, Ending, EventRow, Events, Excursion, Growth, Holding, Holdings, LandingPlace,
    Lane, LeftOutTarget, Mission, More, PlanInForce, PlannedVisit, Plans, ProcedureRow, ProgramContents, ProgramFile,
    ProgramText, QuestionEnd, Questions, RecordStatus, RecordedCommand, RecordedCommands, Report, ResourceRow, Section,
    Signal, SignalKind, SignalLimit, SignalWindow, SignalWindows, Signals, Snippet, StateWord, Statistics, StepRow,
    Surroundings, Target, TargetChange, Targets, Task, Tasks, Timeline, Track, Trouble, TroubleKind, Troubles,
    VisitNeed, Zone,
};
use apex_typescript::{check, declaration};

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
        declaration::<VisitNeed>(),
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
        declaration::<AskedQuestion>(),
        declaration::<QuestionEnd>(),
        declaration::<Questions>(),
        declaration::<StepRow>(),
        declaration::<ProcedureRow>(),
        declaration::<DeclaredName>(),
        declaration::<ProgramFile>(),
        declaration::<ProgramContents>(),
        declaration::<ProgramText>(),
    ];
    check("runtime", "view.ts", "", &declarations).unwrap();
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
    check("runtime", "explain.ts", "\nimport type { Task } from './view';\n", &declarations).unwrap();
}
