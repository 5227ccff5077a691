/** The changes of a plan from the previous one; pure. */

import type { PlanInForce } from './types';

/** Visits whose begins differ by less count as the same. */
const SAME_NS = 60e9;

export interface Change {
  target: string;
  /** Planned begin before and after; null: left out or not in the plan. */
  beforeNs: number | null;
  afterNs: number | null;
  /** Place among the visits, from 1. */
  placeBefore: number | null;
  placeAfter: number | null;
  /** The reason why it is left out, if it is. */
  reason: string;
}

/** The targets for which a plan differs from the previous one, in the order of the new plan; without a previous plan, all targets. */
export function changesOf(plan: PlanInForce, before: PlanInForce | null): Change[] {
  const ids = [...plan.visits, ...plan.left_out, ...(before?.visits ?? []), ...(before?.left_out ?? [])].map(
    one => one.target,
  );
  return [...new Set(ids)].flatMap(target => {
    const [old, now] = [place(before, target), place(plan, target)];
    // A visit that is over when the plan is made is not a change.
    if (
      before &&
      now.beginNs === null &&
      old.beginNs !== null &&
      old.beginNs < plan.adopted_ns &&
      !now.reason
    )
      return [];
    const moved =
      old.beginNs === null || now.beginNs === null
        ? old.beginNs !== now.beginNs || (now.reason !== '' && old.reason === '')
        : Math.abs(old.beginNs - now.beginNs) >= SAME_NS;
    if (before && !moved) return [];
    return [
      {
        target,
        beforeNs: old.beginNs,
        afterNs: now.beginNs,
        placeBefore: old.place,
        placeAfter: now.place,
        reason: now.reason,
      },
    ];
  });
}

function place(
  plan: PlanInForce | null,
  target: string,
): { beginNs: number | null; place: number | null; reason: string } {
  const at = plan?.visits.findIndex(visit => visit.target === target) ?? -1;
  const reason = plan?.left_out.find(one => one.target === target)?.reason ?? '';
  return { beginNs: plan?.visits[at]?.begin_ns ?? null, place: at < 0 ? null : at + 1, reason };
}

/** `added`, `left out`, `12 min later`, `3 min earlier`, `dropped`. */
export function changeWords(change: Change): string {
  const { beforeNs, afterNs, reason } = change;
  if (afterNs === null) return reason ? 'left out' : 'dropped';
  if (beforeNs === null) return 'added';
  const minutes = Math.round(Math.abs(afterNs - beforeNs) / 60e9);
  return `${minutes} min ${afterNs > beforeNs ? 'later' : 'earlier'}`;
}

/** Needed changes that would let a plan visit an omitted target; empty if the planner names no such change. */
export interface Needs {
  value: string;
  window: string;
  fuel: string;
  time: string;
  /** The other obstacles, such as airspace. */
  other: string;
}

const NONE: Needs = { value: '', window: '', fuel: '', time: '', other: '' };

/** The planner's reason, in the column to which it belongs. The figures are the planner's. */
export function needsOf(reason: string): Needs {
  const lack = /^needs (.+?) more than (.+?)( leaves| allows)?(, even alone)?(?:: (.*))?$/.exec(reason);
  if (lack) {
    const [, more = '', limit = '', , alone] = lack;
    const even = alone ? ', even alone' : '';
    // Energy is stated as the time for which it lasts.
    return /fuel|battery|endurance/.test(limit)
      ? { ...NONE, fuel: `for ${more} more${even}` }
      : { ...NONE, time: `${more} more than ${limit}${even}` };
  }
  const loss = /^would lower the score by ([\d.]+)/.exec(reason);
  if (loss) return { ...NONE, value: `at least ${loss[1]} more` };
  const cost = /raise the expected cost from ([\d.]+) to ([\d.]+)/.exec(reason);
  if (cost)
    return { ...NONE, value: `${(Number(cost[2]) - Number(cost[1])).toFixed(2)} more of expected cost` };
  if (/worth nothing/.test(reason)) return { ...NONE, value: 'more than 0, and a manoeuvre that earns it' };
  if (/window closes/.test(reason)) return { ...NONE, window: 'one that closes later' };
  if (/time window|by daylight|by night/.test(reason)) return { ...NONE, window: reason };
  return { ...NONE, other: reason };
}
