// Generated from crates/server by `UPDATE=1 cargo test -p apex-server typescript`. Do not edit.

import type { PlanInForce } from './view';

/**
 * Facts of the mission that the page needs next to its record: all of them are in the mission's files.
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
 * Windows of the wanted looks of targets. The page shows those of targets that are known.
 */
windows: Array<WantedWindow>, };

/**
 * A window in which an image of a target has its full worth.
 */
export type WantedWindow = { target: string, look: string, from_ns: number, to_ns: number, };

/**
 * The run as the API describes it.
 */
export type Operation = { now_ns: number, 
/**
 * Mission seconds per second of wall time; none is as fast as possible.
 */
pace: number | null, paused: boolean, targets: Array<TargetNews>, commands: Array<CommandState>, authority: AuthorityState, 
/**
 * Open questions, oldest first.
 */
questions: Array<OpenQuestion>, 
/**
 * The request that planners work on; mission time stands still meanwhile.
 */
planning: Planning | null, };

/**
 * A question that waits for an answer.
 */
export type OpenQuestion = { agent: string, question: number, text: string, 
/**
 * The choices as printed; none if any answer is taken.
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
 * The goal that it plans for.
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
 * True while the mission counts it as to be observed.
 */
known: boolean, };

/**
 * A command as the API describes it.
 */
export type CommandState = { number: number, words: string, 
/**
 * The name of its author.
 */
by: string, state: 'sent' | 'accepted' | 'rejected' | 'expired', at_ns: number | null, reason: string | null, age_s: number, };

/**
 * Authority as the API describes it.
 */
export type AuthorityState = { 
/**
 * The number of the epoch; commands may state it.
 */
epoch: number, 
/**
 * The holder; none while authority is free.
 */
holder: ActorState | null, 
/**
 * The holder was silent until another operator may take authority.
 */
silent: boolean, offer: OfferState | null, 
/**
 * The caller.
 */
you: ActorState, 
/**
 * The caller holds it.
 */
yours: boolean, 
/**
 * The caller may take it now.
 */
may_take: boolean, 
/**
 * Other callers with a recent request that may hold it.
 */
stations: Array<ActorState>, };

/**
 * An operator or program, as the API describes it.
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
 * The name of the actor that it is offered to.
 */
to: string, 
/**
 * Wall time until it is over, in seconds.
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
 * One of its options as printed, or any answer if it has none.
 */
answer: string, } | { "do": "message", 
/**
 * The agent that hears it; none is all.
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
alarm: string, } | { "do": "take-authority" } | { "do": "offer-authority", 
/**
 * Its name.
 */
to: string, } | { "do": "refuse-authority" } | { "do": "release-authority" };

/**
 * The caller, as the API describes it.
 */
export type SessionState = { name: string, role: 'observer' | 'operator' | 'pilot-in-command', 
/**
 * True if this server needs tokens.
 */
tokens: boolean, };

/**
 * An entry as the API describes it.
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
 * A fork as the API describes it.
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
 * Both reports side by side, as `apex fork` prints them.
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
 * File, line or option at fault, if there is one.
 */
place: string | null, };

/**
 * A draft with the checker's word.
 */
export type DraftAnswer = { at_ns: number, 
/**
 * The plan, if all visits can be made.
 */
plan: PlanInForce | null, 
/**
 * Its expected score, or its expected cost of ignorance.
 */
worth: Worth | null, 
/**
 * Reason if there is no plan.
 */
violation: DraftViolation | null, };

export type Worth = { what: string, value: number, };

/**
 * A mistake in a draft, and its place.
 */
export type DraftViolation = { reason: string, 
/**
 * The place among the visits, from 0; none if the draft as a whole is wrong.
 */
visit: number | null, };
