/** Targets over time: visits, planned times in every plan, windows, factors; pure. */

import { missionTime } from '../time/format';
import type { MissionFacts, PlanInForce, Report, Target, Trouble } from './types';

export interface Visit {
  id: string;
  name: string;
  fromNs: number;
  toNs: number;
  /** The outcome of the visit; `observing` while it continues. */
  state: string;
}

/** The reason of a target that needs no observation any longer, as the record has it. */
const TARGET_GONE = 'no longer a target';

/**
 * The state of a target as shown. A target that was observed remains so when a later plan visits it again or leaves it out: the row says
 * so by text and marks. The number of observed targets is the same everywhere.
 */
export function shownState(target: Pick<Target, 'state' | 'detail' | 'observed_ns'>): string {
  if (target.detail === TARGET_GONE) return 'skipped';
  if (target.observed_ns !== null && target.state !== 'observing') return 'observed';
  return target.state ?? 'known';
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
    const own: Visit[] = [];
    let open: Visit | undefined;
    for (const { state, t_ns } of history) {
      if (state === 'observing' && !open) {
        open = { id, name, fromNs: t_ns, toNs: endNs, state };
        own.push(open);
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
  /** The instant since which all plans leave it out, and the reason of the last of them; null if that plan visits it. */
  left: { sinceNs: number; reason: string } | null;
  /** The instant since which it needs no observation any longer; null while it does. */
  goneNs: number | null;
  /** As flown; none before the report. */
  factors: { name: string; value: number; cause: string }[];
  /** The row as text. */
  words: string;
}

interface Known {
  targets: readonly Target[];
  plans: readonly PlanInForce[];
  troubles: readonly Trouble[];
  facts: MissionFacts | null;
  report: Report | null;
  atNs: number;
}

/** The targets known at the instant, in the order of their planned time, then by name. */
export function targetRows({ targets, plans, troubles, facts, report, atNs }: Known): TargetRow[] {
  const visits = visitsOf(targets, atNs);
  const known = plans.filter(plan => plan.adopted_ns <= atNs);
  const last = known.at(-1);
  const begun = last ? begunVisits(last, targets, atNs) : [];
  const rows = targets.map(target => {
    const own = visits.filter(
      visit => visit.id === target.id && (visit.toNs > visit.fromNs || visit.state === 'observed'),
    );
    const threads = known.flatMap(plan => threadsOf(plan, target.id, plan === last));
    const next = last?.visits.find((visit, index) => visit.target === target.id && begun[index] === null);
    const row = {
      id: target.id,
      name: target.name,
      state: shownState(target),
      value: target.value,
      windows: (facts?.windows ?? [])
        .filter(window => window.target === target.id)
        .map(window => ({ fromNs: window.from_ns, toNs: window.to_ns })),
      threads,
      nextNs: next?.begin_ns ?? null,
      left: leftOf(known, threads),
      visits: own.map(({ fromNs, toNs, state }) => ({ fromNs, toNs, state })),
      reflies: troubles
        .filter(
          trouble =>
            trouble.kind === 'interrupted' &&
            trouble.t_ns <= atNs &&
            own.some(visit => trouble.t_ns >= visit.fromNs && trouble.t_ns <= visit.toNs),
        )
        .map(trouble => trouble.t_ns),
      goneNs: target.detail === TARGET_GONE ? target.since_ns : null,
      factors: factorsOf(report, target.id),
    };
    return { ...row, words: wordsOf(row) };
  });
  const order = (row: TargetRow) =>
    row.visits[0]?.fromNs ??
    row.nextNs ??
    row.threads.findLast(thread => thread.beginNs !== null)?.beginNs ??
    Infinity;
  return rows.sort((a, b) => order(a) - order(b) || a.name.localeCompare(b.name));
}

function threadsOf(plan: PlanInForce, target: string, last: boolean): Thread[] {
  const visits = plan.visits.filter(one => one.target === target).slice(0, last ? undefined : 1);
  if (visits.length > 0)
    return visits.map(visit => ({ plan: plan.number, beginNs: visit.begin_ns, reason: '', last }));
  const left = plan.left_out.find(one => one.target === target);
  return left ? [{ plan: plan.number, beginNs: null, reason: left.reason, last }] : [];
}

function leftOf(plans: readonly PlanInForce[], threads: readonly Thread[]): TargetRow['left'] {
  const run = threads.slice(threads.findLastIndex(thread => thread.beginNs !== null) + 1);
  const first = plans.find(plan => plan.number === run[0]?.plan);
  const last = run.at(-1);
  return first && last ? { sinceNs: first.adopted_ns, reason: last.reason } : null;
}

function factorsOf(report: Report | null, target: string): TargetRow['factors'] {
  const score = report?.sections.find(({ section }) => section === 'score')?.body as
    | { targets?: Record<string, unknown>[] }
    | undefined;
  const found = score?.targets?.find(one => one.target === target);
  if (!found) return [];
  return FACTORS.flatMap(name => {
    const member = found[name];
    const value =
      typeof member === 'object' && member !== null ? (member as { factor: unknown }).factor : member;
    return typeof value === 'number' ? [{ name, value, cause: '' }] : [];
  });
}

/** `Castle Rock, observing, planned T+8:55:00, interrupted 2×, worth up to 90`. */
function wordsOf(row: Omit<TargetRow, 'words'>): string {
  const parts = [row.name, row.state];
  const thread = row.threads.at(-1);
  if (row.goneNs !== null) parts.push(`${TARGET_GONE} since ${missionTime(row.goneNs)}`);
  else if (row.nextNs !== null) parts.push(`planned ${missionTime(row.nextNs)}`);
  else if (thread?.reason) parts.push(`left out: ${thread.reason}`);
  const [first] = row.visits;
  if (first && first.toNs > first.fromNs)
    parts.push(`visited ${missionTime(first.fromNs)} to ${missionTime(first.toNs)}`);
  else if (first) parts.push(`observed ${missionTime(first.fromNs)}`);
  if (row.reflies.length > 0) parts.push(`interrupted ${row.reflies.length}×`);
  if (row.value !== null) parts.push(`worth up to ${row.value}`);
  for (const factor of row.factors) parts.push(`${factor.name} ${factor.value.toFixed(2)}`);
  return parts.join(', ');
}
