// Generated from crates/runtime by `UPDATE=1 cargo test -p apex-runtime typescript`. Do not edit.

import type { Task } from './view';

/**
 * A task at an instant, its neighbours in the tree, and the reasons for its state.
 */
export type TaskExplanation = { 
/**
 * The instant of the question, nanoseconds of mission time.
 */
at_ns: number, 
/**
 * The task then.
 */
task: Task, 
/**
 * Its children then.
 */
children: Array<Task>, 
/**
 * Its state and the cause of that state in one sentence.
 */
now: string, 
/**
 * The cause of that state as text; empty if `now` states none.
 */
cause: string, 
/**
 * The explanation; its history holds the last 60 moments.
 */
explanation: Why, 
/**
 * True if older moments are left out.
 */
left_out: boolean, 
/**
 * Reason for which the instant could not be restored; the explanation is then made from the record's decisions alone.
 */
explanation_error: string | null, };

/**
 * The explanation of a task.
 */
export type Why = { 
/**
 * The task, `T12`.
 */
task: string, 
/**
 * Its step's tag.
 */
tag: string, 
/**
 * Its goal, as known then.
 */
goal: string, 
/**
 * Its state then.
 */
state: string, 
/**
 * Since when, in seconds of mission time.
 */
since: number, 
/**
 * A word of `apex_model::task::OUTCOME_WORDS`, if it has ended.
 */
outcome: string | null, 
/**
 * Its priority at the instant, without interrupt cost; `None` if it has ended.
 */
priority: number | null, 
/**
 * Resources that it holds then.
 */
holds: Array<string>, 
/**
 * Method, `procedure file.pdl:3:1`, if it was selected.
 */
method: string | null, 
/**
 * `file:line:column` of its step.
 */
place: string | null, 
/**
 * Cause of its state, back to a sample, a message or a form of the program.
 */
because: Link | null, 
/**
 * Methods for its goal with the reasons of their order; the chosen one is the first that matches.
 */
choices: Array<Choice>, 
/**
 * History, oldest first.
 */
history: Array<Moment>, 
/**
 * Open requirements at the instant; empty if the task does not wait.
 */
waiting: Array<Unmet>, 
/**
 * Holder of the resource over which the task lost its last conflict; `None` if it has won since.
 */
blocked: Blocked | null, 
/**
 * Its subtasks that live then.
 */
subtasks: Array<Subtask>, 
/**
 * [`EXPLANATION_VERSION`].
 */
version: number, 
/**
 * `why` or `why-not`.
 */
question: string, 
/**
 * Kind of the subject: `task`, `resource`, `command`, `target`, `step`, `procedure`.
 */
kind: string, 
/**
 * The subject, as written in the question.
 */
asked: string, 
/**
 * The agent.
 */
agent: string, 
/**
 * The instant of the question, in seconds of mission time.
 */
t: number, };

/**
 * Head of every answer.
 */
export type About = { 
/**
 * [`EXPLANATION_VERSION`].
 */
version: number, 
/**
 * `why` or `why-not`.
 */
question: string, 
/**
 * Kind of the subject: `task`, `resource`, `command`, `target`, `step`, `procedure`.
 */
kind: string, 
/**
 * The subject, as written in the question.
 */
asked: string, 
/**
 * The agent.
 */
agent: string, 
/**
 * The instant of the question, in seconds of mission time.
 */
t: number, };

/**
 * An event or decision, with the links on which it rests.
 */
export type Link = { 
/**
 * Instant, in seconds of mission time.
 */
t: number, 
/**
 * The task, `T3`, if the link concerns one.
 */
task: string | null, 
/**
 * Its number, 3 for `T3`.
 */
task_number: number | null, 
/**
 * Event: `T3 (photograph fire) started`.
 */
what: string, 
/**
 * The kind of cause; `None` for an input from outside.
 */
kind: string | null, 
/**
 * Reason, as text; empty for inputs from outside.
 */
because: string, 
/**
 * The cause with its parts; `None` for an input from outside.
 */
cause: CauseDetail | null, 
/**
 * `file:line:column` of the clause of PDL.
 */
place: string | null, 
/**
 * The text of that line.
 */
source: string | null, 
/**
 * The links on which it rests.
 */
causes: Array<Link>, 
/**
 * True if further links exist beyond the requested depth.
 */
more: boolean, };

/**
 * An event or decision about a task.
 */
export type Moment = { 
/**
 * The decision's number in the record.
 */
id: number, 
/**
 * Seconds of mission time.
 */
t: number, 
/**
 * The kind of the effect; `docs/reference/flight-record.md` lists them.
 */
kind: string, 
/**
 * Event, as text.
 */
what: string, 
/**
 * Reason, as text; empty if `what` is complete.
 */
because: string, 
/**
 * `file:line:column` of the clause of PDL.
 */
place: string | null, 
/**
 * State before, for `transition`.
 */
from: string | null, 
/**
 * State after, for `transition`.
 */
to: string | null, 
/**
 * A word of `apex_model::task::OUTCOME_WORDS`, for the transition to `terminated`.
 */
outcome: string | null, 
/**
 * The goal, form, clause, resource or variable concerned.
 */
subject: string, 
/**
 * The selected method, for `selected`.
 */
method: MethodDetail | null, 
/**
 * The cause with its parts; `None` for a moment that is not a decision.
 */
cause: CauseDetail | null, };

/**
 * Method for a goal.
 */
export type MethodDetail = { 
/**
 * `procedure`, `primitive`, `built-in` or `solver`.
 */
kind: string, 
/**
 * `file:line:column` of the procedure or primitive.
 */
place: string | null, 
/**
 * The solver's name.
 */
name: string | null, };

/**
 * A cause, taken from the decision itself. Its text is in the member `because` of the same object.
 */
export type CauseDetail = { 
/**
 * The kind of cause; `docs/reference/trace.md` lists them.
 */
kind: string, 
/**
 * Things that the text names.
 */
parts: Array<CausePart>, 
/**
 * Observations, in the order of the text.
 */
evidence: Array<Observation>, 
/**
 * The observations as text, without the cause that they prove; empty if there are none.
 */
observed: string, };

/**
 * A part of a cause.
 */
export type CausePart = { 
/**
 * Role of the part in the cause: `parent`, `resource`, `clause`.
 */
role: string, } & ({ "type": "task", 
/**
 * `T3`
 */
task: string, } | { "type": "form", 
/**
 * The text.
 */
form: string, } | { "type": "name", 
/**
 * The name.
 */
name: string, } | { "type": "number", 
/**
 * The number.
 */
number: number, } | { "type": "span", 
/**
 * Its length in seconds.
 */
seconds: number, } | { "type": "strength", 
/**
 * Its priority or rank.
 */
priority: number, 
/**
 * Its interrupt cost; 0 unless it holds the resource.
 */
interrupt_cost: number, } | { "type": "share", 
/**
 * The resource.
 */
resource: string, 
/**
 * The amount with its unit; null means the whole amount.
 */
amount: string | null, } | { "type": "message", 
/**
 * The sentence.
 */
message: string, });

/**
 * The value of a part.
 */
export type PartValue = { "type": "task", 
/**
 * `T3`
 */
task: string, } | { "type": "form", 
/**
 * The text.
 */
form: string, } | { "type": "name", 
/**
 * The name.
 */
name: string, } | { "type": "number", 
/**
 * The number.
 */
number: number, } | { "type": "span", 
/**
 * Its length in seconds.
 */
seconds: number, } | { "type": "strength", 
/**
 * Its priority or rank.
 */
priority: number, 
/**
 * Its interrupt cost; 0 unless it holds the resource.
 */
interrupt_cost: number, } | { "type": "share", 
/**
 * The resource.
 */
resource: string, 
/**
 * The amount with its unit; null means the whole amount.
 */
amount: string | null, } | { "type": "message", 
/**
 * The sentence.
 */
message: string, };

/**
 * An observation. Instants are seconds of mission time.
 */
export type Observation = { "type": "sample", 
/**
 * The state variable.
 */
variable: string, 
/**
 * Its value with its unit.
 */
value: string, 
/**
 * Instant of the measurement.
 */
at: number, } | { "type": "event", 
/**
 * Its form.
 */
form: string, 
/**
 * Arrival.
 */
at: number, } | { "type": "task-state", 
/**
 * The task, `T3`.
 */
task: string, 
/**
 * The word of the state.
 */
word: string, 
/**
 * Instant of the change.
 */
at: number, } | { "type": "task-end", 
/**
 * The task, `T3`.
 */
task: string, 
/**
 * Its number, 3 for `T3`.
 */
task_number: number, 
/**
 * Instant of the end.
 */
at: number, } | { "type": "run", 
/**
 * The state variable.
 */
variable: string, 
/**
 * The first sample's instant.
 */
from: number, 
/**
 * The last sample's instant.
 */
to: number, 
/**
 * Number of samples.
 */
samples: number, } | { "type": "instant", 
/**
 * Start of the delay, if there is one.
 */
from: number | null, 
/**
 * The instant.
 */
at: number, } | { "type": "function", 
/**
 * The expression as PDL text.
 */
expression: string, 
/**
 * Its value.
 */
value: string, 
/**
 * Instant.
 */
at: number, } | { "type": "absence", 
/**
 * The condition as PDL text.
 */
condition: string, 
/**
 * Instant up to which it was not true.
 */
at: number, } | { "type": "estimate", 
/**
 * The state variable.
 */
variable: string, 
/**
 * The estimated value.
 */
value: string, 
/**
 * The estimator, by its PDL name.
 */
estimator: string, 
/**
 * The instant of the estimate.
 */
at: number, } | { "type": "aggregate", 
/**
 * The state variable.
 */
variable: string, 
/**
 * The statistic, by its PDL name without the colon.
 */
name: string, 
/**
 * Its value.
 */
value: string, 
/**
 * Start of its interval.
 */
from: number, 
/**
 * End of its interval.
 */
to: number, 
/**
 * Number of samples.
 */
samples: number, };

/**
 * A procedure, primitive or solver that could have served a goal.
 */
export type Choice = { 
/**
 * `procedure file.pdl:3:1`
 */
method: string, 
/**
 * `file:line:column` of a procedure or primitive.
 */
place: string | null, 
/**
 * Its index.
 */
index: string, 
/**
 * True if it matches the goal.
 */
matches: boolean, 
/**
 * Reason for its order: first, later, or not matching.
 */
because: string, };

/**
 * One open requirement.
 */
export type Unmet = { 
/**
 * Kind.
 */
kind: string, 
/**
 * The part of the condition as PDL text, or the reason as text.
 */
what: string, 
/**
 * Present state; empty if `what` is complete.
 */
now: string, 
/**
 * True for a part of a condition about which no sample or message has arrived.
 */
unobserved: boolean, 
/**
 * Since when, in seconds of mission time, where that is known.
 */
since: number | null, 
/**
 * Instant at which it is met by time alone, if nothing changes before, in seconds of mission time.
 */
until: number | null, 
/**
 * Distance of the newest sample from the threshold, with its unit.
 */
distance: string | null, 
/**
 * The other task concerned, `T4`; `None` if it concerns no other task.
 */
task: string | null, 
/**
 * Its number, 4 for `T4`.
 */
task_number: number | null, 
/**
 * Position in the PDL text.
 */
place: string | null, };

/**
 * A lost conflict.
 */
export type Blocked = { 
/**
 * The winner, `T4`.
 */
by: string, 
/**
 * The winner's goal.
 */
goal: string, 
/**
 * The resource.
 */
resource: string, 
/**
 * Since when, in seconds of mission time.
 */
since: number, 
/**
 * The winner's priority or rank, with its interrupt cost where it defended.
 */
winner_priority: number, 
/**
 * The loser's priority or rank.
 */
loser_priority: number, 
/**
 * The part of the winner's priority that is its interrupt cost.
 */
winner_cost: number, 
/**
 * The part of the loser's priority that is its interrupt cost.
 */
loser_cost: number, 
/**
 * Both strengths as text for operators: `5 against 0 + interrupt cost 0.1`.
 */
strengths: string, };

/**
 * A living subtask.
 */
export type Subtask = { 
/**
 * The task, `T13`.
 */
task: string, 
/**
 * Its goal.
 */
goal: string, 
/**
 * Its state.
 */
state: string, };

/**
 * A variable of a task.
 */
export type Binding = { 
/**
 * Its name with the question mark.
 */
name: string, 
/**
 * Its value as PDL text.
 */
value: string, };

/**
 * A part of a condition with its present state.
 */
export type MonitoredCondition = { 
/**
 * Kind of the part: `and`, `or`, `measurement`, `episode`, `event`, ..
 */
kind: string, 
/**
 * The part as PDL text.
 */
text: string, 
/**
 * True if the part holds; null if the data do not decide.
 */
holds: boolean | null, 
/**
 * The state variable that the part watches.
 */
variable: string | null, 
/**
 * The newest value of that variable, with its unit.
 */
value: string | null, 
/**
 * Constraints on the value, resolved: `> 15deg`.
 */
limits: Array<string>, 
/**
 * The present state of the part as text.
 */
now: string, 
/**
 * Instant since which the part holds, or since which its present state has been known; nanoseconds of mission time.
 */
since_ns: number | null, 
/**
 * Instant at which the part becomes true by time alone; nanoseconds of mission time.
 */
until_ns: number | null, 
/**
 * `file:line:column` of the part.
 */
place: string, 
/**
 * Its parts.
 */
parts: Array<MonitoredCondition>, };

/**
 * A clause that a task watches.
 */
export type TaskMonitor = { 
/**
 * The task's number.
 */
task: number, 
/**
 * The task's goal, as known at the instant.
 */
goal: string, 
/**
 * The clause: `waitfor`, `restart-when`, ..
 */
clause: string, 
/**
 * Its condition.
 */
condition: MonitoredCondition, };

/**
 * Conditions that living tasks watch at an instant.
 */
export type Monitors = { 
/**
 * The instant, nanoseconds of mission time.
 */
at_ns: number, 
/**
 * One entry for each watched clause, in order of the tasks' creation.
 */
monitors: Array<TaskMonitor>, 
/**
 * The variables of the requested task with their values; empty without a task.
 */
bindings: Array<Binding>, };
