// Generated from crates/runtime by `UPDATE=1 cargo test -p apex-runtime typescript`. Do not edit.

/** A task's state. */
export type TaskState = "pending" | "enabled" | "ongoing" | "interrupted" | "terminated";

/**
 * State of the record.
 */
export type RecordStatus = "complete" | "live" | "incomplete";

/**
 * How far the record has grown.
 */
export type Growth = { 
/**
 * Mission time in nanoseconds of the last thing recorded.
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
 * Facts about the flight.
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
 * Mission time in nanoseconds of the first thing recorded.
 */
from_ns: number, 
/**
 * Why the flight ended, if it has.
 */
end_reason: string | null, 
/**
 * Number of tasks.
 */
tasks: number, 
/**
 * Number of observation targets.
 */
targets: number, 
/**
 * The mission's score, if the report has one.
 */
score: number | null, 
/**
 * Mission time in nanoseconds of the last thing recorded.
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
 * One list per quantity, all of the same length, by time.
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
 * Its goal as last known in the record.
 */
goal: string, 
/**
 * Its state.
 */
state: TaskState, 
/**
 * `success`, `failure` or `cut`, if it has ended.
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
 * `procedure file.pdl:3:1`, if one was selected.
 */
method: string | null, 
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
 * A stretch of time that a task spent in one state.
 */
export type Bar = { 
/**
 * The task's number.
 */
task: number, 
/**
 * Its state.
 */
state: TaskState, 
/**
 * Start, nanoseconds of mission time.
 */
from_ns: number, 
/**
 * End, nanoseconds of mission time.
 */
to_ns: number, };

/**
 * The tasks of one step.
 */
export type Lane = { 
/**
 * The step's tag.
 */
tag: string, 
/**
 * The goal of the first task.
 */
goal: string, 
/**
 * Nesting in the tree of all lanes; a root has 0.
 */
depth: number, 
/**
 * Number of tasks.
 */
tasks: number, 
/**
 * Nanoseconds in which its tasks were enabled, ongoing or interrupted.
 */
active_ns: number, 
/**
 * Bars that do not overlap, row by row.
 */
rows: Array<Array<Bar>>, 
/**
 * Number of intervals that the limits of a lane leave out.
 */
left_out: number, };

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
 * In the order of the task tree: a lane comes before the lanes below it.
 */
lanes: Array<Lane>, 
/**
 * Number of lanes that the limit leaves out; their tasks were active for less time.
 */
left_out: number, };

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
 * The task's number, if it is about one.
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
 * `success`, `failure` or `cut`, for the transition to `terminated`.
 */
outcome: string | null, 
/**
 * The goal, form or variable.
 */
subject: string | null, 
/**
 * The cause, or what was said, without the place.
 */
text: string | null, 
/**
 * `file:line:column` of the clause of PDL.
 */
place: string | null, };

/**
 * The last effects of the time asked for, oldest first.
 */
export type Events = { 
/**
 * The effects.
 */
events: Array<EventRow>, 
/**
 * True if older effects of that time are left out.
 */
more: boolean, };

/**
 * A change of a target's state.
 */
export type TargetChange = { 
/**
 * Mission time in nanoseconds.
 */
t_ns: number, 
/**
 * The new state.
 */
state: string, 
/**
 * Why.
 */
detail: string | null, };

/**
 * An observation target.
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
 * Its value to the mission.
 */
value: number | null, 
/**
 * GeoJSON.
 */
geometry: GeoJSON.Geometry | GeoJSON.Feature | GeoJSON.FeatureCollection | null, 
/**
 * `planned`, `observing`, `observed` or `skipped` at the instant asked for; none before the first.
 */
state: string | null, 
/**
 * Why it is in this state.
 */
detail: string | null, 
/**
 * Mission time in nanoseconds at which this state began.
 */
since_ns: number | null, 
/**
 * All changes over the whole record, oldest first.
 */
history: Array<TargetChange>, };

/**
 * All targets.
 */
export type Targets = { 
/**
 * By identifier.
 */
targets: Array<Target>, };

/**
 * A section of the report.
 */
export type Section = { 
/**
 * Its name.
 */
section: string, 
/**
 * JSON if the record has JSON, else a text.
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
