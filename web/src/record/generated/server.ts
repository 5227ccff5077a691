// Generated from crates/server by `UPDATE=1 cargo test -p apex-server typescript`. Do not edit.

import type { PlanInForce } from './view';

/**
 * Facts of the mission that the page needs in addition to its record, all from the mission's files.
 */
export type MissionFacts = { 
/**
 * `fixed-wing` or `rotorcraft`.
 */
kind: 'fixed-wing' | 'rotorcraft', 
/**
 * Length of the mission as planned, nanoseconds.
 */
duration_ns: number, 
/**
 * Greatest distance from a landing place that the mission allows, metres; none if it states none.
 */
landing_distance_m_max: number | null, 
/**
 * Windows of the wanted looks of targets. The page shows those of known targets.
 */
windows: Array<WantedWindow>, };

/**
 * A window in which an image of a target has its full worth.
 */
export type WantedWindow = { target: string, look: string, from_ns: number, to_ns: number, };

/**
 * The run in the form of the API.
 */
export type Operation = { now_ns: number, 
/**
 * Milliseconds of the server's clock, from which callers compute `until_ms` of their commands.
 */
clock_ms: number, 
/**
 * Mission seconds per second of wall time; `None` is as fast as possible.
 */
pace: number | null, paused: boolean, targets: Array<TargetNews>, commands: Array<CommandState>, authority: AuthorityState, 
/**
 * Open questions, oldest first.
 */
questions: Array<OpenQuestion>, 
/**
 * The request on which planners work; mission time stops meanwhile.
 */
planning: Planning | null, };

/**
 * A question that waits for an answer.
 */
export type OpenQuestion = { agent: string, question: number, text: string, 
/**
 * The choices as printed; empty if any answer is accepted.
 */
options: Array<string>, 
/**
 * Answer taken at the deadline; `None` fails the task.
 */
default: string | null, asked_ns: number, 
/**
 * The deadline.
 */
by_ns: number | null, };

/**
 * A planner at work.
 */
export type Planning = { 
/**
 * The goal of the requested plan.
 */
goal: string, 
/**
 * Wall time since the request, in seconds.
 */
since_s: number, };

/**
 * Change of a target by an operator.
 */
export type TargetNews = { id: string, 
/**
 * True while the mission treats it as a target to observe.
 */
known: boolean, };

/**
 * A command in the form of the API.
 */
export type CommandState = { number: number, words: string, 
/**
 * The name of its author.
 */
by: string, state: 'sent' | 'accepted' | 'rejected' | 'expired', at_ns: number | null, reason: string | null, age_s: number, };

/**
 * Authority in the form of the API.
 */
export type AuthorityState = { 
/**
 * The number of the epoch, which commands may state.
 */
epoch: number, 
/**
 * The holder; `None` while authority is free.
 */
holder: ActorState | null, 
/**
 * True if the holder is silent: another operator may then take authority.
 */
silent: boolean, offer: OfferState | null, 
/**
 * The caller.
 */
you: ActorState, 
/**
 * True if the caller holds authority.
 */
yours: boolean, 
/**
 * True if the caller may take authority now.
 */
may_take: boolean, 
/**
 * Other callers with a recent request that may hold it.
 */
stations: Array<ActorState>, };

/**
 * An operator or program, in the form of the API.
 */
export type ActorState = { name: string, 
/**
 * `observer`, `operator` or `pilot-in-command`.
 */
role: string, };

/**
 * An offer of authority.
 */
export type OfferState = { 
/**
 * The name of the actor to which it is offered.
 */
to: string, 
/**
 * Remaining wall time of the offer, in seconds.
 */
left_s: number, };

/**
 * The body of `POST /api/commands`.
 */
export type Wish = { "do": "pause" } | { "do": "resume" } | { "do": "pace", 
/**
 * The pace.
 */
pace: number | null, } | { "do": "step" } | { "do": "stop" } | { "do": "answer", 
/**
 * The agent that asks.
 */
agent: string, 
/**
 * The question's number.
 */
question: number, 
/**
 * One of its options as printed, or any answer if it has no options.
 */
answer: string, } | { "do": "message", 
/**
 * The agent that receives it; `None` for all.
 */
agent?: string, 
/**
 * The form.
 */
form: string, } | { "do": "add-target", 
/**
 * Its id.
 */
target: string, } | { "do": "remove-target", 
/**
 * Its id.
 */
target: string, } | { "do": "value-target", 
/**
 * Its id.
 */
target: string, 
/**
 * The value.
 */
value: number, } | { "do": "acknowledge", 
/**
 * The alarm, as text.
 */
alarm: string, 
/**
 * Mission time in nanoseconds at which it was raised last.
 */
at_ns: number, 
/**
 * The signal that raised it; `None` for other alarms.
 */
signal?: string, } | { "do": "take-authority" } | { "do": "offer-authority", 
/**
 * Its name.
 */
to: string, } | { "do": "refuse-authority" } | { "do": "release-authority" };

/**
 * The caller in the form of the API.
 */
export type SessionState = { name: string, role: 'observer' | 'operator' | 'pilot-in-command', 
/**
 * True if this server needs tokens.
 */
tokens: boolean, };

/**
 * An entry in the form of the API.
 */
export type ShelfRow = { 
/**
 * Its number; 0 is the served record with the agent that is shown first.
 */
id: number, 
/**
 * The record's file name.
 */
record: string, 
/**
 * The agent's name.
 */
agent: string, 
/**
 * The mission's name.
 */
mission: string | null, 
/**
 * Changes of a fork and the instant of the first; null for other records.
 */
fork: ForkRow | null, };

export type ForkRow = { at_ns: number, with: string, };

/**
 * A fork in the form of the API.
 */
export type ForkState = { id: number, at_ns: number, with: string, file: string, 
/**
 * `flying`, `ended` or `failed`.
 */
state: 'flying' | 'ended' | 'failed', now_ns: number, 
/**
 * Its number in `/api/records`, once it has ended.
 */
record: number | null, 
/**
 * Comparison of both reports, in the form of `apex fork`.
 */
comparison: string | null, failure: Failure | null, };

/**
 * The body of `POST /api/forks`.
 */
export type ForkRequest = { 
/**
 * The instant from which the flight differs, nanoseconds of mission time.
 */
at_ns: number, 
/**
 * Factor of the wind that blows after the instant.
 */
wind_factor: number | null, 
/**
 * Seed of turbulence and radio links after the instant.
 */
seed: number | null, 
/**
 * Visits in this order instead of planning.
 */
plan: Array<string>, 
/**
 * Messages after the instant.
 */
inputs: Array<InputRequest>, };

/**
 * A message at an instant.
 */
export type InputRequest = { 
/**
 * Seconds of mission time.
 */
t: number, 
/**
 * A form of PDL.
 */
event: string, };

/**
 * Failure with reason, place and remedy.
 */
export type Failure = { 
/**
 * Failure.
 */
message: string, 
/**
 * Reason, if known.
 */
reason: string | null, 
/**
 * Remedy, if known.
 */
help: string | null, 
/**
 * File, line or option with the error, if there is one.
 */
place: string | null, };

/**
 * A draft with the checker's verdict.
 */
export type DraftAnswer = { at_ns: number, 
/**
 * The plan, if all visits can be made.
 */
plan: PlanInForce | null, 
/**
 * The expected score of the plan, or its expected cost of ignorance.
 */
worth: Worth | null, 
/**
 * The reason, if there is no plan.
 */
violation: DraftViolation | null, };

export type Worth = { what: string, value: number, };

/**
 * A mistake in a draft, and its place.
 */
export type DraftViolation = { reason: string, 
/**
 * The place among the visits, from 0; `None` if the whole draft is wrong.
 */
visit: number | null, };

/**
 * Kind of a remedy for which the page has words.
 */
export type Remedy = "session" | "role" | "tasks" | "records";
