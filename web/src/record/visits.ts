/** Targets over time: visits, planned times in every plan, windows, factors; pure. */

import { clock, missionTime, NANOSECONDS_PER_SECOND, plannedClock } from '../time/format';
import { INTERRUPTED } from './interrupted';
import { reasonText } from './plans';
import type { MissionFacts, PlanInForce, Report, Target, Trouble } from './types';

export interface Visit {
  id: string;
  name: string;
  fromNs: number;
  toNs: number;
  /** The outcome of the visit; `observing` while it continues. */
  state: string;
}

/** True for a target that needs no observation any longer. */
export function isGone(target: Pick<Target, 'gone_ns'>): boolean {
  return target.gone_ns !== null;
}

/**
 * The state of a target as shown. A target that was observed remains so when a later plan visits it again or leaves it out: the row
 * shows it by text and marks. The number of observed targets is the same everywhere.
 */
export function shownState(
  target: Pick<Target, 'id' | 'state' | 'gone_ns' | 'observed_ns' | 'history'>,
  plan: PlanInForce | null = null,
): string {
  if (isGone(target)) return 'skipped';
  if (target.observed_ns !== null && target.state !== 'observing') return 'observed';
  if (target.state === INTERRUPTED || isUnmentioned(target, plan)) return 'known';
  return target.state ?? 'known';
}

/** True if the target's state comes from an earlier plan, and the plan in force neither visits the target nor leaves it out. */
export function isUnmentioned(
  target: Pick<Target, 'id' | 'state' | 'history'>,
  plan: PlanInForce | null,
): boolean {
  if (!plan || (target.state !== 'planned' && target.state !== 'skipped')) return false;
  // Each plan records the states of its targets again.
  const last = target.history.at(-1);
  if (!last || last.t_ns >= plan.adopted_ns) return false;
  return entriesOf(plan, target.id) === NO_ENTRIES;
}

/** The instant since which the reason of the target's state has been the present one: several plans may keep the state. */
export function reasonSince(target: Pick<Target, 'state' | 'detail' | 'history'>): number | null {
  const other = target.history.findLastIndex(
    change => change.state !== target.state || change.detail !== target.detail,
  );
  return target.history[other + 1]?.t_ns ?? null;
}

/** The instant at which each visit of a plan was begun, in the order of the plan; null before. The n-th visit to a target is its n-th
 * observation since the plan. */
export function begunVisits(plan: PlanInForce, targets: readonly Target[], atNs: number): (number | null)[] {
  const begun = new Map<string, number[]>();
  for (const target of targets) {
    // A plan may continue the visit that is going on when it is adopted.
    const own = visitsOf([target], Infinity).filter(
      visit => visit.toNs > visit.fromNs && visit.toNs >= plan.adopted_ns && visit.fromNs <= atNs,
    );
    begun.set(
      target.id,
      own.map(visit => visit.fromNs),
    );
  }
  return plan.visits.map(visit => begun.get(visit.target)?.shift() ?? null);
}

/** The visits of the targets with their results, in order of time; a result without a visit, such as `skipped`, has no duration. */
export function visitsOf(targets: readonly Target[], endNs: number): Visit[] {
  const visits = targets.flatMap(({ id, name, history }) => {
    if (history.length === 0) return [];
    const own: Visit[] = [];
    let open: Visit | undefined;
    for (const { state, t_ns } of history) {
      if (state === 'observing' && !open) {
        open = { id, name, fromNs: t_ns, toNs: endNs, state };
        own.push(open);
      } else if (state === INTERRUPTED) {
        if (open) Object.assign(open, { toNs: t_ns, state });
        open = undefined;
      } else if (state === 'observed' || state === 'skipped') {
        if (open) Object.assign(open, { toNs: t_ns, state });
        else own.push({ id, name, fromNs: t_ns, toNs: t_ns, state });
        open = undefined;
      }
      // A plan made during the visit plans it again; the visit continues.
    }
    return own;
  });
  return visits.sort((a, b) => a.fromNs - b.fromNs);
}

/** The factors of a visit, in the order in which they are multiplied. */
export const FACTORS = ['coverage', 'resolution', 'clarity', 'timing'] as const;

/** A target's planned time in one plan; null if the plan leaves it out. */
export interface Thread {
  plan: number;
  beginNs: number | null;
  /** The reason why the plan leaves it out. */
  reason: string;
  /** True for the plan in force. */
  last: boolean;
  /** True for a visit of the plan in force that has begun. */
  begun: boolean;
}

/** A reason with the instant of the plan that stated it. */
export interface StatedReason {
  sinceNs: number;
  reason: string;
}

export interface TargetRow {
  id: string;
  name: string;
  state: string;
  value: number | null;
  windows: { fromNs: number; toNs: number }[];
  /** The planned times: of each earlier plan the first, of the plan in force all. */
  threads: Thread[];
  /** The planned begin of the next visit in the plan in force. */
  nextNs: number | null;
  visits: { fromNs: number; toNs: number; state: string }[];
  /** Times at which a task of its observation was interrupted, so that it is flown again. */
  reflies: number[];
  /** The instant since which all plans leave it out, with the reason of the first of them; null if the plan in force does not leave it
   * out. `later` is the reason of the plan in force where it differs, with the instant of the first plan that stated it. */
  left: (StatedReason & { later: StatedReason | null }) | null;
  /** The plan in force if it does not mention the target; null otherwise. */
  unmentioned: StatedReason | null;
  /** The instant at which it was first seen without a visit. */
  passingNs: number | null;
  /** The instant since which it needs no observation any longer; null while it does. */
  goneNs: number | null;
  /** As flown; none before the report. */
  factors: { name: string; value: number; cause: string }[];
  /** Points as flown; null before the report. */
  worth: number | null;
  /** The row as text. */
  words: string;
}

interface Known {
  targets: readonly Target[];
  plans: readonly PlanInForce[];
  troubles: readonly Trouble[];
  facts: MissionFacts | null;
  report: Report | null;
  /** Instants at which targets were seen without a visit. */
  passing?: ReadonlyMap<string, number>;
  atNs: number;
}

/** Compares names as the browser's language orders them; made once, because making it takes longer than many comparisons. */
const COLLATOR = new Intl.Collator();

/** The targets known at the instant, in the order of their planned time, then by name. */
export function targetRows({ targets, plans, troubles, facts, report, passing, atNs }: Known): TargetRow[] {
  const known = plans.filter(plan => plan.adopted_ns <= atNs);
  const last = known.at(-1);
  const begun = last ? begunVisits(last, targets, atNs) : [];
  const interruptions = troubles.filter(one => one.kind === 'interrupted' && one.t_ns <= atNs);
  const rows = targets.map(target => {
    const own = visitsOf([target], atNs).filter(
      visit => visit.toNs > visit.fromNs || visit.state === 'observed',
    );
    const threads = known.flatMap(plan => threadsOf(plan, target.id, plan === last ? begun : null));
    const nextIndex = last && entriesOf(last, target.id).visits.find(index => begun[index] === null);
    const next = nextIndex === undefined ? undefined : last?.visits[nextIndex];
    const row = {
      id: target.id,
      name: target.name,
      state: shownState(target, last),
      value: target.value,
      windows: (facts?.windows ?? [])
        .filter(window => window.target === target.id)
        .map(window => ({ fromNs: window.from_ns, toNs: window.to_ns })),
      threads,
      nextNs: next?.begin_ns ?? null,
      left: last && isLeftOut(last, target.id) ? leftOf(known, threads) : null,
      unmentioned: last && isUnmentioned(target, last) ? notInPlan(last) : null,
      visits: own.map(({ fromNs, toNs, state }) => ({ fromNs, toNs, state })),
      reflies: interruptions
        .filter(({ t_ns }) => own.some(visit => t_ns >= visit.fromNs && t_ns <= visit.toNs))
        .map(trouble => trouble.t_ns),
      passingNs: passing?.get(target.id) ?? null,
      goneNs: target.gone_ns,
      factors: factorsOf(report, target.id),
      worth: worthOf(report, target.id),
    };
    return { ...row, words: wordsOf(row) };
  });
  const order = (row: TargetRow) =>
    row.visits[0]?.fromNs ??
    row.nextNs ??
    row.threads.findLast(thread => thread.beginNs !== null)?.beginNs ??
    Infinity;
  return rows.sort((a, b) => order(a) - order(b) || COLLATOR.compare(a.name, b.name));
}

/** The entries of a plan about a target: the indices of its visits in the plan, and the reason why the plan leaves it out. */
interface PlanEntries {
  visits: number[];
  leftOut: string | null;
}

/** The entries of each plan by target; plans do not change. */
const ENTRIES = new WeakMap<PlanInForce, Map<string, PlanEntries>>();
const NO_ENTRIES: PlanEntries = { visits: [], leftOut: null };

function entriesOf(plan: PlanInForce, target: string): PlanEntries {
  const known = ENTRIES.get(plan);
  if (known) return known.get(target) ?? NO_ENTRIES;
  const entries = new Map<string, PlanEntries>();
  const of = (id: string): PlanEntries => {
    const found = entries.get(id) ?? { visits: [], leftOut: null };
    entries.set(id, found);
    return found;
  };
  plan.visits.forEach((visit, index) => {
    of(visit.target).visits.push(index);
  });
  for (const one of plan.left_out) of(one.target).leftOut ??= one.reason;
  ENTRIES.set(plan, entries);
  return entries.get(target) ?? NO_ENTRIES;
}

/** The planned times of a target; `begun` are the instants at which the visits of the plan in force have begun, null for earlier plans. */
function threadsOf(plan: PlanInForce, target: string, begun: readonly (number | null)[] | null): Thread[] {
  const common = { plan: plan.number, last: begun !== null };
  const { visits, leftOut } = entriesOf(plan, target);
  if (visits.length === 0)
    return leftOut === null ? [] : [{ ...common, beginNs: null, reason: leftOut, begun: false }];
  return (begun ? visits : visits.slice(0, 1)).map(index => ({
    ...common,
    beginNs: plan.visits[index]?.begin_ns ?? null,
    reason: '',
    begun: (begun?.[index] ?? null) !== null,
  }));
}

function isLeftOut(plan: PlanInForce, target: string): boolean {
  return entriesOf(plan, target).leftOut !== null;
}

/** `not in plan 2 of 0:16:56`: the plan neither visits the target nor states why. */
export function notInPlan(plan: PlanInForce): StatedReason {
  const adopted = clock(plan.adopted_ns / NANOSECONDS_PER_SECOND);
  return { sinceNs: plan.adopted_ns, reason: `not in plan ${plan.number} of ${adopted}` };
}

function leftOf(plans: readonly PlanInForce[], threads: readonly Thread[]): TargetRow['left'] {
  const run = threads.slice(threads.findLastIndex(thread => thread.beginNs !== null) + 1);
  const stated = (thread: Thread | undefined): StatedReason | null => {
    const plan = plans.find(one => one.number === thread?.plan);
    return plan && thread ? { sinceNs: plan.adopted_ns, reason: thread.reason } : null;
  };
  const first = stated(run[0]);
  const later = stated(run[run.findLastIndex(thread => thread.reason !== run.at(-1)?.reason) + 1]);
  if (!first) return null;
  return { ...first, later: later && later.reason !== first.reason ? later : null };
}

/** `left out since 0:11:21: no time`, with the later reason where a plan stated another one. */
export function leftWords({ sinceNs, reason, later }: NonNullable<TargetRow['left']>): string {
  const at = (atNs: number) => clock(atNs / NANOSECONDS_PER_SECOND);
  const first = `left out since ${at(sinceNs)}: ${reasonText(reason)}`;
  return later ? `${first}; since ${at(later.sinceNs)}: ${reasonText(later.reason)}` : first;
}

/** A target in the report's score; reports of older records have only its name. */
function scoreOf(report: Report | null, target: string): Record<string, unknown> | undefined {
  const score = report?.sections.find(({ section }) => section === 'score')?.body as
    | { targets?: Record<string, unknown>[] }
    | undefined;
  return score?.targets?.find(one => (one.id ?? one.target) === target);
}

function worthOf(report: Report | null, target: string): number | null {
  const worth = scoreOf(report, target)?.worth;
  return typeof worth === 'number' ? worth : null;
}

function factorsOf(report: Report | null, target: string): TargetRow['factors'] {
  const found = scoreOf(report, target);
  if (!found) return [];
  return FACTORS.flatMap(name => {
    const member = found[name];
    const value =
      typeof member === 'object' && member !== null ? (member as { factor: unknown }).factor : member;
    return typeof value === 'number' ? [{ name, value, cause: '' }] : [];
  });
}

/** `Castle Rock, observing, planned T+8:55:00, 2 visits, last T+7:10:00 to T+7:12:00, interrupted 2×, worth up to 90`. */
function wordsOf(row: Omit<TargetRow, 'words'>): string {
  const parts = [row.name, row.state];
  if (row.goneNs !== null) parts.push(`no longer a target since ${missionTime(row.goneNs)}`);
  else if (row.nextNs !== null) parts.push(`planned T+${plannedClock(row.nextNs)}`);
  else if (row.left) parts.push(leftWords(row.left));
  else if (row.unmentioned) parts.push(row.unmentioned.reason);
  if (row.passingNs !== null) parts.push(passingWords(row.passingNs));
  const last = row.visits.at(-1);
  if (last) parts.push(visitWords(last, row.visits.length));
  if (row.reflies.length > 0) parts.push(`interrupted ${row.reflies.length}×`);
  const worth = worthWords(row);
  if (worth) parts.push(`worth ${worth}`);
  for (const factor of row.factors) parts.push(`${factor.name} ${factor.value.toFixed(2)}`);
  return parts.join(', ');
}

/** `44.5 of 45` as flown; before the report `up to 45`; empty without a value. */
export function worthWords({ worth, value }: Pick<TargetRow, 'worth' | 'value'>): string {
  if (worth !== null) return value === null ? worth.toFixed(1) : `${worth.toFixed(1)} of ${value}`;
  return value === null ? '' : `up to ${value}`;
}

/** `seen in passing at 0:08:58`. */
export function passingWords(atNs: number): string {
  return `seen in passing at ${clock(atNs / NANOSECONDS_PER_SECOND)}`;
}

/** The last of the visits, after their number if there are several. */
function visitWords({ fromNs, toNs, state }: TargetRow['visits'][number], count: number): string {
  const from = missionTime(fromNs);
  const span = toNs > fromNs ? `${from} to ${missionTime(toNs)}` : from;
  if (count > 1) return `${count} visits, last ${state === 'observing' ? `since ${from}` : span}`;
  if (state === 'observing') return `visited since ${from}`;
  return toNs > fromNs ? `visited ${span}` : `observed ${from}`;
}
