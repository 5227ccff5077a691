// Generated from crates/server by `UPDATE=1 cargo test -p apex-server typescript`. Do not edit.

import type { PlanInForce } from './view';

export type MissionFacts = { kind: 'fixed-wing' | 'rotorcraft', landing_distance_m_max: number | null, windows: Array<WantedWindow>, };
export type WantedWindow = { target: string, look: string, from_ns: number, to_ns: number, };
export type Operation = { now_ns: number, pace: number | null, paused: boolean, targets: Array<TargetNews>, commands: Array<CommandState>, authority: AuthorityState, questions: Array<OpenQuestion>, planning: Planning | null, };
export type OpenQuestion = { agent: string, question: number, text: string, options: Array<string>, default: string | null, asked_ns: number, by_ns: number | null, };
export type Planning = { goal: string, since_s: number, };
export type TargetNews = { id: string, known: boolean, };
export type CommandState = { number: number, words: string, by: string, state: 'sent' | 'accepted' | 'rejected' | 'expired', at_ns: number | null, reason: string | null, age_s: number, };
export type AuthorityState = { epoch: number, holder: ActorState | null, silent: boolean, offer: OfferState | null, you: ActorState, yours: boolean, may_take: boolean, stations: Array<ActorState>, };
export type ActorState = { name: string, role: string, };
export type OfferState = { to: string, left_s: number, };
export type Wish = { "do": "pause" } | { "do": "resume" } | { "do": "pace", pace: number | null, } | { "do": "step" } | { "do": "stop" } | { "do": "answer", agent: string, question: number, answer: string, } | { "do": "message", agent?: string, form: string, } | { "do": "add-target", target: string, } | { "do": "remove-target", target: string, } | { "do": "value-target", target: string, value: number, } | { "do": "acknowledge", alarm: string, } | { "do": "take-authority" } | { "do": "offer-authority", to: string, } | { "do": "refuse-authority" } | { "do": "release-authority" };
export type SessionState = { name: string, role: 'observer' | 'operator' | 'pilot-in-command', tokens: boolean, };
export type ShelfRow = { id: number, record: string, agent: string, mission: string | null, fork: ForkRow | null, };
export type ForkRow = { at_ns: number, with: string, };
export type ForkState = { id: number, at_ns: number, with: string, file: string, state: 'flying' | 'ended' | 'failed', now_ns: number, record: number | null, comparison: string | null, failure: Failure | null, };
export type ForkRequest = { at_ns: number, wind_factor: number | null, seed: number | null, plan: Array<string>, inputs: Array<InputRequest>, };
export type InputRequest = { t: number, event: string, };
export type Failure = { message: string, reason: string | null, help: string | null, place: string | null, };
export type DraftAnswer = { at_ns: number, plan: PlanInForce | null, worth: Worth | null, violation: DraftViolation | null, };
export type Worth = { what: string, value: number, };
export type DraftViolation = { reason: string, visit: number | null, };
