// Generated from crates/runtime by `UPDATE=1 cargo test -p apex-runtime typescript`. Do not edit.

/** A task's state. */
export type TaskState = "pending" | "enabled" | "ongoing" | "interrupted" | "terminated";

/**
 * State of the record.
 */
export type RecordStatus = "complete" | "live" | "incomplete";

/**
 * Growth of a record.
 */
export type Growth = { 
/**
 * Mission time in nanoseconds of the last recorded step.
 */
end_ns: number, 
/**
 * Number of executive steps.
 */
batches: number, 
/**
 * State of the record.
 */
status: RecordStatus, };

/**
 * End of a flight.
 */
export type Ending = { 
/**
 * Reason.
 */
reason: string, 
/**
 * True if its initial task failed.
 */
failed: boolean, };

/**
 * Facts about the flight, as known at an instant.
 */
export type Mission = { 
/**
 * The mission's name.
 */
mission: string | null, 
/**
 * The agent's name.
 */
agent: string | null, 
/**
 * The vehicle's name.
 */
vehicle: string | null, 
/**
 * The version of Apex that wrote the record.
 */
apex_version: string | null, 
/**
 * The record's file name.
 */
record: string, 
/**
 * Civil time of mission time 0, RFC 3339.
 */
epoch_utc: string | null, 
/**
 * Mission time in nanoseconds of the first recorded step.
 */
from_ns: number, 
/**
 * End of the flight; `None` before.
 */
ending: Ending | null, 
/**
 * Number of tasks created by the instant.
 */
tasks: number, 
/**
 * Number of observation targets known by the instant.
 */
targets: number, 
/**
 * Number of these targets that were observed by the instant.
 */
observed: number, 
/**
 * The mission's score, if the report contains one; `None` before the flight's end.
 */
score: number | null, 
/**
 * Kind of the score: `mission-score`, of which more is better, or `expected-cost-of-ignorance`, of which less is; none without
 * a score, and for scores that do not say it.
 */
score_kind: string | null, 
/**
 * Mission time in nanoseconds of the last recorded step.
 */
end_ns: number, 
/**
 * Number of executive steps.
 */
batches: number, 
/**
 * State of the record.
 */
status: RecordStatus, };

/**
 * One list per quantity, all of the same length, in order of time.
 */
export type Track = { 
/**
 * Mission time in nanoseconds.
 */
t_ns: Array<number>, 
/**
 * Degrees north.
 */
latitude_deg: Array<number | null>, 
/**
 * Degrees east.
 */
longitude_deg: Array<number | null>, 
/**
 * Metres above sea level.
 */
altitude_m: Array<number | null>, 
/**
 * Degrees from north, clockwise.
 */
heading_deg: Array<number | null>, 
/**
 * Degrees, right wing down positive.
 */
roll_deg: Array<number | null>, 
/**
 * Metres per second.
 */
ground_speed_mps: Array<number | null>, 
/**
 * Kilograms.
 */
fuel_kg: Array<number | null>, 
/**
 * Number of samples in the record for this time; more than the lists hold if they are thinned.
 */
recorded: number, };

/**
 * A task at an instant.
 */
export type Task = { 
/**
 * Its number: 12 for `T12`.
 */
id: number, 
/**
 * Its parent's number.
 */
parent: number | null, 
/**
 * Its step's tag.
 */
tag: string, 
/**
 * Its goal as known at that time.
 */
goal: string, 
/**
 * Identifiers of the targets that the goal names.
 */
targets: Array<string>, 
/**
 * True if it only sends a message or asks a question.
 */
is_message: boolean, 
/**
 * Its state.
 */
state: TaskState, 
/**
 * A word of `apex_model::task::OUTCOME_WORDS`, if it has ended.
 */
outcome: string | null, 
/**
 * Mission time in nanoseconds at which the state began.
 */
since_ns: number, 
/**
 * Mission time in nanoseconds of its creation.
 */
created_ns: number, 
/**
 * `procedure file.pdl:3:1`, if a method was selected by the instant.
 */
method: string | null, 
/**
 * `file:line:column` of that method; null for a built-in activity and a solver.
 */
method_place: string | null, 
/**
 * `file:line:column` of its step.
 */
place: string | null, };

/**
 * The task tree at an instant.
 */
export type Tasks = { 
/**
 * Mission time in nanoseconds.
 */
at_ns: number, 
/**
 * The selected tasks with all their ancestors, by number, so that parents come before their children.
 */
tasks: Array<Task>, 
/**
 * Number of tasks in each state at that time.
 */
counts: { [key in TaskState]?: number }, 
/**
 * Number of matching tasks that the limit leaves out.
 */
left_out: number, };

/**
 * A span of time, about a pixel wide, with more intervals than can be drawn. Its JSON is the list of its first pixel, its number of
 * pixels, its count, and its ongoing share in thousandths.
 */
export type Band = [number, number, number, number];

/**
 * The tasks of one step.
 */
export type Lane = { 
/**
 * The step's tag.
 */
tag: string, 
/**
 * The goal of the first task in the window, as known at the requested instant.
 */
goal: string, 
/**
 * Nesting in the tree of all lanes; a root has 0.
 */
depth: number, 
/**
 * Number of tasks in the window.
 */
tasks: number, 
/**
 * Nanoseconds of the window in which its tasks were enabled, ongoing or interrupted.
 */
active_ns: number, 
/**
 * Bars that do not overlap, row by row and by time. In JSON each row is a list of runs, which are bars of one task without a gap
 * between them: `[task, from_ns, state, length, state, length, ..]`, lengths in nanoseconds. States are numbers: 0 pending,
 * 1 enabled, 2 ongoing, 3 interrupted.
 */
rows: number[][][], 
/**
 * Intervals that are too dense for bars, by time.
 */
bands: Array<Band>, };

/**
 * The lanes beyond the limit, combined.
 */
export type More = { 
/**
 * Number of lanes.
 */
lanes: number, 
/**
 * Number of their tasks.
 */
tasks: number, 
/**
 * Their intervals.
 */
bands: Array<Band>, };

/**
 * Lanes of task states over time.
 */
export type Timeline = { 
/**
 * Start of the window, nanoseconds of mission time.
 */
from_ns: number, 
/**
 * End of the window, nanoseconds of mission time.
 */
to_ns: number, 
/**
 * Mission time in nanoseconds up to which the flight is known.
 */
at_ns: number, 
/**
 * Nanoseconds of a pixel, in which bands are measured.
 */
pixel_ns: number, 
/**
 * In the order of the task tree: a lane comes before the lanes below it.
 */
lanes: Array<Lane>, 
/**
 * The lanes that the limit leaves out; their tasks were active for less time.
 */
more: More, };

/**
 * An effect.
 */
export type EventRow = { 
/**
 * Its number in the record, from 1.
 */
id: number, 
/**
 * Mission time in nanoseconds.
 */
t_ns: number, 
/**
 * `transition`, `command`, `solve`, ..: `docs/reference/flight-record.md` lists them.
 */
kind: string, 
/**
 * The number of the task concerned, if there is one.
 */
task: number | null, 
/**
 * State before, for `transition`.
 */
from_state: string | null, 
/**
 * State after, for `transition`.
 */
to_state: string | null, 
/**
 * A word of `apex_model::task::OUTCOME_WORDS`, for the transition to `terminated`.
 */
outcome: string | null, 
/**
 * The goal, form or variable.
 */
subject: string | null, 
/**
 * The cause or the message, without the place.
 */
text: string | null, 
/**
 * `file:line:column` of the clause of PDL.
 */
place: string | null, };

/**
 * The last effects of the requested time, oldest first.
 */
export type Events = { 
/**
 * The effects.
 */
events: Array<EventRow>, 
/**
 * True if older effects of that time are left out.
 */
more: boolean, 
/**
 * Number of the effect before which the search for a text continues; null if the query was answered to its end or limit.
 */
next: number | null, };

/**
 * A recorded state of a target; each plan records it again.
 */
export type TargetChange = { 
/**
 * Mission time in nanoseconds.
 */
t_ns: number, 
/**
 * The state.
 */
state: string, 
/**
 * Reason.
 */
detail: string | null, };

/**
 * An observation target, as known at an instant.
 */
export type Target = { 
/**
 * Its name in PDL.
 */
id: string, 
/**
 * Its name for operators.
 */
name: string, 
/**
 * Centre, degrees north.
 */
latitude_deg: number | null, 
/**
 * Centre, degrees east.
 */
longitude_deg: number | null, 
/**
 * Its value to the mission at that instant: that of its files, or of the last message `(new-value ID NUMBER)`.
 */
value: number | null, 
/**
 * GeoJSON.
 */
geometry: GeoJSON.Geometry | GeoJSON.Feature | GeoJSON.FeatureCollection | null, 
/**
 * `planned`, `observing`, `observed` or `skipped` at the requested instant; `None` before the first state.
 */
state: string | null, 
/**
 * Reason for its state: that of the latest plan, where several in a row keep the state.
 */
detail: string | null, 
/**
 * Mission time in nanoseconds at which this state began. A later plan that keeps the state does not change it.
 */
since_ns: number | null, 
/**
 * Mission time in nanoseconds of its announcement; `None` if it was known from the start.
 */
announced_ns: number | null, 
/**
 * Mission time in nanoseconds since which it needs no observation any longer; none if it needs one.
 */
gone_ns: number | null, 
/**
 * Mission time in nanoseconds of the end of its last observation; none if it was not observed by then.
 */
observed_ns: number | null, 
/**
 * Recorded changes up to that instant, oldest first, at most 500 entries.
 */
history: Array<TargetChange>, };

/**
 * The targets that are known at an instant.
 */
export type Targets = { 
/**
 * By identifier.
 */
targets: Array<Target>, };

/**
 * A planned visit.
 */
export type PlannedVisit = { 
/**
 * The target's identifier.
 */
target: string, 
/**
 * Predicted begin, nanoseconds of mission time.
 */
begin_ns: number, 
/**
 * Predicted end, nanoseconds of mission time.
 */
end_ns: number, };

/**
 * Change that a visit would need.
 */
export type VisitNeed = { "kind": "time", 
/**
 * Seconds.
 */
more_s: number, 
/**
 * The limit that leaves less: `the end of the mission`, `endurance`.
 */
limit: string, 
/**
 * True if energy is the limit.
 */
is_energy: boolean, 
/**
 * True if the target cannot be visited as the only one either.
 */
alone: boolean, } | { "kind": "value", 
/**
 * Points of the score that a visit would cost; none if any value is missing.
 */
more: number | null, } | { "kind": "cost", 
/**
 * Difference of the expected cost.
 */
more: number, } | { "kind": "window" };

/**
 * A target without a visit.
 */
export type LeftOutTarget = { 
/**
 * The target's identifier.
 */
target: string, 
/**
 * Reason.
 */
reason: string, 
/**
 * Change that a visit would need, by the planner's own arithmetic; none where it states no obstacle as a value, and in records
 * of earlier versions.
 */
needs: VisitNeed | null, };

/**
 * The plan in force at an instant.
 */
export type PlanInForce = { 
/**
 * Number of plans adopted so far: 1 for the first plan.
 */
number: number, 
/**
 * Mission time in nanoseconds of its adoption.
 */
adopted_ns: number, 
/**
 * One line about it.
 */
summary: string, 
/**
 * Its visits in order, with the predicted times.
 */
visits: Array<PlannedVisit>, 
/**
 * Positions along its route, `[longitude, latitude]` in degrees; empty if the plan states none.
 */
route: Array<[number, number]>, 
/**
 * The targets that the plan leaves out.
 */
left_out: Array<LeftOutTarget>, };

/**
 * The plans adopted by an instant.
 */
export type Plans = { 
/**
 * By number. Only the last two have their routes.
 */
plans: Array<PlanInForce>, 
/**
 * Number of earlier plans that are not listed, because there are more than [`PLANS_MAX`].
 */
left_out: number, };

/**
 * A span of time in which a task held a resource, or a share of it.
 */
export type Holding = { 
/**
 * The task's number.
 */
task: number, 
/**
 * The share that it held; `None` for the whole resource.
 */
amount: string | null, 
/**
 * Begin in nanoseconds of mission time.
 */
from_ns: number, 
/**
 * End in nanoseconds of mission time; that of the answer if it is still held.
 */
to_ns: number, 
/**
 * True while it is held.
 */
open: boolean, };

/**
 * A resource over time.
 */
export type ResourceRow = { 
/**
 * The resource, as written in PDL.
 */
resource: string, 
/**
 * Spans of time in which a task held the resource, by beginning.
 */
holdings: Array<Holding>, 
/**
 * Number of earlier holdings in the window that are left out.
 */
left_out: number, };

/**
 * The resources of an agent with their holders.
 */
export type Holdings = { 
/**
 * One row for each resource that any task has held by the instant, in the order of the first holding.
 */
resources: Array<ResourceRow>, };

/**
 * Kind of an entry.
 */
export type TroubleKind = "failed" | "interrupted" | "fault" | "left-out" | "ended";

/**
 * A failure, an interruption or a fault.
 */
export type Trouble = { 
/**
 * Mission time in nanoseconds.
 */
t_ns: number, 
/**
 * Kind of the entry.
 */
kind: TroubleKind, 
/**
 * The goal, target or message concerned.
 */
subject: string, 
/**
 * Cause; empty for a fault whose message is its cause.
 */
cause: string, 
/**
 * The number of the task concerned, if there is one.
 */
task: number | null, 
/**
 * The number of the subtask whose failure is the cause.
 */
failed_child: number | null, 
/**
 * The number of the task that handles the failure, for the fault that reports a handled failure.
 */
handler_task: number | null, 
/**
 * The goal of that task as known at the instant of the query.
 */
handler: string | null, 
/**
 * `file:line:column` of the clause of PDL.
 */
place: string | null, 
/**
 * The target's identifier, if the entry concerns a target.
 */
target: string | null, 
/**
 * Identifiers of the targets that the goal of the task concerned names.
 */
targets: Array<string>, 
/**
 * The kind of the cause, a word of `docs/reference/flight-record.md`; null for entries that are not decisions.
 */
cause_kind: string | null, };

/**
 * Failures, interruptions and faults up to an instant.
 */
export type Troubles = { 
/**
 * By time.
 */
troubles: Array<Trouble>, 
/**
 * Number of older entries that the limit leaves out.
 */
left_out: number, };

/**
 * A zone of airspace.
 */
export type Zone = { 
/**
 * Its name for operators.
 */
name: string, 
/**
 * True if the flight must stay inside, false if it must stay out.
 */
permitted: boolean, 
/**
 * Lower face, metres above mean sea level.
 */
altitude_m_min: number, 
/**
 * Upper face, metres above mean sea level; none if the file states none.
 */
altitude_m_max: number | null, 
/**
 * Active intervals as start and end in hours of mission time; empty if it is always active.
 */
active_h: Array<[number, number]>, 
/**
 * GeoJSON.
 */
geometry: GeoJSON.Geometry, };

/**
 * A place to land.
 */
export type LandingPlace = { 
/**
 * Its name for operators.
 */
name: string, 
/**
 * True for a base, false for an emergency landing place.
 */
base: boolean, 
/**
 * Degrees north.
 */
latitude_deg: number, 
/**
 * Degrees east.
 */
longitude_deg: number, };

/**
 * The surroundings of a flight.
 */
export type Surroundings = { 
/**
 * Zones in the order of the mission's files.
 */
zones: Array<Zone>, 
/**
 * Bases and emergency landing places.
 */
landing_places: Array<LandingPlace>, };

/**
 * A section of the report.
 */
export type Section = { 
/**
 * Its name.
 */
section: string, 
/**
 * JSON if the record contains JSON, otherwise text.
 */
body: unknown, };

/**
 * The report of a flight.
 */
export type Report = { 
/**
 * Its sections in order; none before the flight has ended.
 */
sections: Array<Section>, };

/**
 * Lines around a place.
 */
export type Snippet = { 
/**
 * The file's name in the record.
 */
name: string, 
/**
 * The place's line, from 1.
 */
line: number, 
/**
 * The number of the first of `lines`, from 1.
 */
first_line: number, 
/**
 * The lines.
 */
lines: Array<string>, };

/**
 * Kind of the values of a signal.
 */
export type SignalKind = "number" | "words" | "other";

/**
 * A limit or threshold of a signal. Values beyond it satisfy the condition.
 */
export type SignalLimit = { 
/**
 * Values below this one are beyond the limit, in the signal's unit; `None` if low values are within.
 */
low: number | null, 
/**
 * Values above this one are beyond the limit, in the signal's unit; `None` if high values are within.
 */
high: number | null, 
/**
 * Seconds for which values must be beyond it; `None` if one sample suffices.
 */
duration_s: number | null, 
/**
 * Further conditions as PDL text; empty if there are none.
 */
also: string, 
/**
 * True if a step that repeats or responds watches it; false for a threshold that a step awaits once.
 */
guarded: boolean, 
/**
 * The step that its condition starts, by its tag.
 */
step: string, 
/**
 * `file:line:column` of the condition.
 */
place: string, };

/**
 * A recorded state variable.
 */
export type Signal = { 
/**
 * Its name in PDL, `(roll-angle aircraft-1)`.
 */
name: string, 
/**
 * Its attribute, `roll-angle`.
 */
attribute: string, 
/**
 * Its object, `aircraft-1`.
 */
object: string, 
/**
 * The unit of its numbers in PDL; empty for numbers without a unit and for words.
 */
unit: string, 
/**
 * Kind of its values.
 */
kind: SignalKind, 
/**
 * Mission time in nanoseconds of its first sample.
 */
first_ns: number, 
/**
 * The limits that the mission watches.
 */
limits: Array<SignalLimit>, };

/**
 * The signals that were measured by an instant.
 */
export type Signals = { 
/**
 * In order of their first sample.
 */
signals: Array<Signal>, };

/**
 * A stretch of time in which all samples were beyond a limit.
 */
export type Excursion = { 
/**
 * The limit's place in the list of limits.
 */
limit: number, 
/**
 * Mission time in nanoseconds of the first sample beyond it.
 */
from_ns: number, 
/**
 * Mission time in nanoseconds of the last sample beyond it.
 */
to_ns: number, 
/**
 * The value farthest beyond it.
 */
peak: number, 
/**
 * Number of samples.
 */
samples: number, 
/**
 * Instant at which the executive found the condition satisfied by the excursion, nanoseconds of mission time. `None` if it did not:
 * the excursion was too short, the condition was not watched, or another part did not hold.
 */
raised_ns: number | null, };

/**
 * Statistics of the samples of a window, each sample with the same weight.
 */
export type Statistics = { 
/**
 * Number of samples.
 */
samples: number, 
/**
 * The smallest value.
 */
low: number, 
/**
 * The largest value.
 */
high: number, 
/**
 * The mean.
 */
mean: number, 
/**
 * The standard deviation of the samples about their mean.
 */
deviation: number, 
/**
 * The first value.
 */
first: number, 
/**
 * The last value.
 */
last: number, };

/**
 * A signal in a window of time. All lists have the same length: one entry for each sample, or, if there are more samples, for each pixel
 * that has samples. The last sample before the window comes first, so that a line enters the window.
 */
export type SignalWindow = { 
/**
 * Mission time in nanoseconds of the first sample of the entry.
 */
t_ns: Array<number>, 
/**
 * The smallest value.
 */
low: Array<number>, 
/**
 * The largest value.
 */
high: Array<number>, 
/**
 * The mean of the values; for words the index in `words` of the last one.
 */
mean: Array<number>, 
/**
 * Number of samples.
 */
count: Array<number>, 
/**
 * The words of a signal of words.
 */
words: Array<string>, 
/**
 * Statistics of the samples in the window; none without samples, and for words.
 */
statistics: Statistics | null, 
/**
 * Number of samples in the window.
 */
samples: number, 
/**
 * The stretches of the window in which samples were beyond a limit, by time.
 */
excursions: Array<Excursion>, 
/**
 * Number of shorter excursions, which the executive did not answer, that are left out.
 */
left_out: number, 
/**
 * Its name in PDL, `(roll-angle aircraft-1)`.
 */
name: string, 
/**
 * Its attribute, `roll-angle`.
 */
attribute: string, 
/**
 * Its object, `aircraft-1`.
 */
object: string, 
/**
 * The unit of its numbers in PDL; empty for numbers without a unit and for words.
 */
unit: string, 
/**
 * Kind of its values.
 */
kind: SignalKind, 
/**
 * Mission time in nanoseconds of its first sample.
 */
first_ns: number, 
/**
 * The limits that the mission watches.
 */
limits: Array<SignalLimit>, };

/**
 * Windows of signals.
 */
export type SignalWindows = { 
/**
 * Start of the window, nanoseconds of mission time.
 */
from_ns: number, 
/**
 * End of the window, nanoseconds of mission time.
 */
to_ns: number, 
/**
 * Mission time in nanoseconds up to which the flight is known.
 */
at_ns: number, 
/**
 * One window for each requested name, in that order; names without samples by the instant have none.
 */
windows: Array<SignalWindow>, };

/**
 * A command of an operator and its end.
 */
export type RecordedCommand = { 
/**
 * Mission time in nanoseconds at which the run decided about it.
 */
t_ns: number, 
/**
 * Its number.
 */
number: number, 
/**
 * The command as text.
 */
words: string, 
/**
 * `accepted`, `rejected` or `expired`.
 */
end: string, 
/**
 * Reason of a rejection or an expiry; `None` for other ends.
 */
reason: string | null, 
/**
 * The alarm that it acknowledges.
 */
alarm: string | null, };

/**
 * Operator commands that were decided by an instant.
 */
export type RecordedCommands = { 
/**
 * By time.
 */
commands: Array<RecordedCommand>, };

/**
 * A question to operators.
 */
export type AskedQuestion = { 
/**
 * Its number.
 */
question: number, 
/**
 * The number of the task that asks.
 */
task: number, 
/**
 * The question.
 */
text: string, 
/**
 * Choices; without any, every form is an answer.
 */
options: Array<string>, 
/**
 * The answer that is taken if none comes in time; none fails the task.
 */
default: string | null, 
/**
 * Mission time in nanoseconds at which it was asked.
 */
asked_ns: number, 
/**
 * Mission time in nanoseconds at which the time of the operators is over.
 */
by_ns: number | null, 
/**
 * Mission time in nanoseconds from which it was open no longer; null while it is open.
 */
closed_ns: number | null, 
/**
 * End of it; null while it is open.
 */
ended: QuestionEnd | null, };

/**
 * End of a question.
 */
export type QuestionEnd = { "how": "answered", 
/**
 * The answer.
 */
answer: string, 
/**
 * Name of the operator, if the record states it: that of a command to a run.
 */
author: string | null, } | { "how": "default", 
/**
 * The default.
 */
answer: string, } | { "how": "withdrawn", 
/**
 * Reason.
 */
reason: string, } | { "how": "task-ended" };

/**
 * Questions by an instant.
 */
export type Questions = { 
/**
 * By the instant at which they were asked.
 */
questions: Array<AskedQuestion>, 
/**
 * Number of earlier questions that are left out; all of them are closed.
 */
left_out: number, };

/**
 * A step of a procedure.
 */
export type StepRow = { 
/**
 * Its tag.
 */
tag: string, 
/**
 * Its activity as PDL text.
 */
activity: string, 
/**
 * `file:line:column`
 */
place: string, 
/**
 * The tags of the steps for whose end it waits.
 */
after: Array<string>, 
/**
 * Other conditions for which it waits, as PDL text.
 */
waits: Array<string>, 
/**
 * True if it repeats or responds.
 */
repeats: boolean, 
/**
 * True if it ends the procedure.
 */
ends: boolean, };

/**
 * A procedure, primitive or solver.
 */
export type ProcedureRow = { 
/**
 * `procedure`, `primitive` or `solver`.
 */
kind: string, 
/**
 * The class of goals that the definition serves.
 */
index: string, 
/**
 * `file:line:column`
 */
place: string, 
/**
 * Order of the steps: `concurrent`, `sequential`, `ranked`, `soft-sequential`; empty without steps.
 */
order: string, 
/**
 * The steps in written order.
 */
steps: Array<StepRow>, };

/**
 * A declared name.
 */
export type DeclaredName = { 
/**
 * The name.
 */
name: string, 
/**
 * Details of the declaration: a unit, `unitary`, `capacity 3`.
 */
detail: string, 
/**
 * `file:line:column` of the declaration.
 */
place: string, };

/**
 * A file of the program.
 */
export type ProgramFile = { 
/**
 * Its name in the record.
 */
name: string, 
/**
 * Number of its lines.
 */
lines: number, };

/**
 * Declarations of the program of a record.
 */
export type ProgramContents = { 
/**
 * The files, in the order in which they were loaded.
 */
files: Array<ProgramFile>, 
/**
 * The names of the agents, in the order of their numbers.
 */
agents: Array<string>, 
/**
 * Procedures, primitives and solvers, in written order of each kind.
 */
procedures: Array<ProcedureRow>, 
/**
 * Declared resources.
 */
resources: Array<DeclaredName>, 
/**
 * Declared state variables; others may be measured, too.
 */
variables: Array<DeclaredName>, };

/**
 * A file of the program with its text.
 */
export type ProgramText = { 
/**
 * Its name in the record.
 */
name: string, 
/**
 * Its lines.
 */
lines: Array<string>, };
