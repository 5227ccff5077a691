/** Rows of targets and of resources on the timeline's axis; pure. */

import type { Range } from '../../player/clock';
import type { MissionFacts } from '../../record/seen';
import type { Holdings, PlanInForce, Report, Target, Trouble } from '../../record/types';
import { missionTime } from '../../time/format';
import type { Scale } from './view';
import { NAMES_PX, visitsOf } from './view';

/** The factors of a visit, in the order in which they are multiplied. */
export const FACTORS = ['coverage', 'resolution', 'clarity', 'timing'] as const;

/** A target's planned time in one plan; null if the plan leaves it out. */
export interface Thread {
  plan: number;
  beginNs: number | null;
  /** Why the plan leaves it out. */
  reason: string;
  /** It is the plan in force. */
  last: boolean;
}

export interface TargetRow {
  id: string;
  name: string;
  state: string;
  value: number | null;
  windows: { fromNs: number; toNs: number }[];
  threads: Thread[];
  visits: { fromNs: number; toNs: number; state: string }[];
  /** When a task of its observation was interrupted: it is flown again. */
  reflies: number[];
  /** As flown; none before the report. */
  factors: { name: string; value: number; cause: string }[];
  /** The row in words. */
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
  const last = known.at(-1)?.number;
  const rows = targets.map(target => {
    const own = visits.filter(visit => visit.id === target.id && visit.toNs > visit.fromNs);
    const threads = known.flatMap(plan => threadOf(plan, target.id, plan.number === last));
    const row = {
      id: target.id,
      name: target.name,
      state: target.state ?? 'known',
      value: target.value,
      windows: (facts?.windows ?? [])
        .filter(window => window.target === target.id)
        .map(window => ({ fromNs: window.from_ns, toNs: window.to_ns })),
      threads,
      visits: own.map(({ fromNs, toNs, state }) => ({ fromNs, toNs, state })),
      reflies: troubles
        .filter(
          trouble =>
            trouble.kind === 'interrupted' &&
            trouble.t_ns <= atNs &&
            own.some(visit => trouble.t_ns >= visit.fromNs && trouble.t_ns <= visit.toNs),
        )
        .map(trouble => trouble.t_ns),
      factors: factorsOf(report, target.id),
    };
    return { ...row, words: wordsOf(row) };
  });
  const order = (row: TargetRow) =>
    row.visits[0]?.fromNs ?? row.threads.findLast(thread => thread.beginNs !== null)?.beginNs ?? Infinity;
  return rows.sort((a, b) => order(a) - order(b) || a.name.localeCompare(b.name));
}

function threadOf(plan: PlanInForce, target: string, last: boolean): Thread[] {
  const visit = plan.visits.find(one => one.target === target);
  if (visit) return [{ plan: plan.number, beginNs: visit.begin_ns, reason: '', last }];
  const left = plan.left_out.find(one => one.target === target);
  return left ? [{ plan: plan.number, beginNs: null, reason: left.reason, last }] : [];
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

/** `Castle Rock, observing, planned 8:55, interrupted twice, worth up to 90`. */
function wordsOf(row: Omit<TargetRow, 'words'>): string {
  const parts = [row.name, row.state];
  const thread = row.threads.at(-1);
  if (thread?.beginNs != null) parts.push(`planned ${missionTime(thread.beginNs)}`);
  else if (thread) parts.push(`left out: ${thread.reason}`);
  const [first] = row.visits;
  if (first) parts.push(`visited ${missionTime(first.fromNs)} to ${missionTime(first.toNs)}`);
  if (row.reflies.length > 0) parts.push(`interrupted ${row.reflies.length}×`);
  if (row.value !== null) parts.push(`worth up to ${row.value}`);
  for (const factor of row.factors) parts.push(`${factor.name} ${factor.value.toFixed(2)}`);
  return parts.join(', ');
}

export interface HoldingBar {
  x: number;
  width: number;
  task: number;
  /** Holdings in the bar: more than one where they are narrower than a pixel. */
  count: number;
  words: string;
}

export interface ResourceRowView {
  resource: string;
  bars: HoldingBar[];
  holder: string;
  leftOut: number;
}

/** Who holds each resource, as bars of the window; holdings narrower than a pixel are one bar with a count. */
export function resourceRows(
  holdings: Holdings | null,
  visible: Range,
  atNs: number,
  scale: Scale,
  phrase: (task: number) => string,
): ResourceRowView[] {
  return (holdings?.resources ?? []).map(row => {
    const bars: HoldingBar[] = [];
    let holder = 'free';
    for (const one of row.holdings) {
      if (one.from_ns > atNs) continue;
      if (one.open || one.to_ns >= atNs) holder = `T${one.task} ${phrase(one.task)}`.trim();
      const toNs = Math.min(one.to_ns, atNs, visible.toNs);
      if (toNs < visible.fromNs || one.from_ns > visible.toNs) continue;
      const x = Math.max(scale.x(one.from_ns), NAMES_PX);
      const width = Math.max(scale.x(toNs) - x, 1);
      const last = bars.at(-1);
      const narrow = last && (last.count > 1 || last.width <= 1);
      if (last && narrow && width <= 1 && x - (last.x + last.width) < 1) {
        last.width = Math.max(last.width, x + width - last.x);
        last.count += 1;
        last.words = `${last.count} holdings`;
        continue;
      }
      const amount = one.amount ? `${one.amount}, ` : '';
      bars.push({
        x,
        width,
        task: one.task,
        count: 1,
        words: `${amount}T${one.task} ${phrase(one.task)}`.trim(),
      });
    }
    return { resource: row.resource, bars, holder, leftOut: row.left_out };
  });
}
