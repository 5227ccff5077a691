/** The changes of a plan from the previous one; pure. */

import type { LeftOutTarget, PlanInForce } from './types';

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
  return `${neededTime(60 * minutes)} ${afterNs > beforeNs ? 'later' : 'earlier'}`;
}

/** Needed changes that would let a plan visit an omitted target; empty if the planner names no such change. */
export interface Needs {
  value: string;
  window: string;
  fuel: string;
  time: string;
  /** The other obstacles, such as airspace, in the planner's words. */
  other: string;
}

const NONE: Needs = { value: '', window: '', fuel: '', time: '', other: '' };

/** `23 s`, `1 min 41 s`, `8 min`, `3 h 5 min`: a time in whole seconds, rounded up. */
function neededTime(seconds: number): string {
  const whole = Math.ceil(seconds);
  const parts = [
    [Math.floor(whole / 3600), 'h'],
    [Math.floor(whole / 60) % 60, 'min'],
    [whole % 60, 's'],
  ] as const;
  const words = parts.filter(([count]) => count > 0).map(([count, unit]) => `${count} ${unit}`);
  return words.join(' ') || '0 s';
}

/** Seconds within a reason as minutes: `needs 101 s more` becomes `needs 1 min 41 s more`. */
export function reasonText(reason: string): string {
  return reason.replace(/\b(\d{2,}) s\b/g, (text, seconds: string) =>
    Number(seconds) >= 60 ? neededTime(Number(seconds)) : text,
  );
}

/** The changes without which a plan cannot visit a target that was left out, each in its column. The figures are the planner's own. */
export function needsOf({ needs, reason }: Pick<LeftOutTarget, 'needs' | 'reason'>): Needs {
  switch (needs?.kind) {
    case 'time': {
      const even = needs.alone ? ', even alone' : '';
      const more = neededTime(needs.more_s);
      // Energy is stated as the time that it lasts.
      return needs.is_energy
        ? { ...NONE, fuel: `for ${more} more${even}` }
        : { ...NONE, time: `${more} more than ${needs.limit}${even}` };
    }
    case 'value':
      return {
        ...NONE,
        value: needs.more === null ? 'more than 0' : `at least ${needs.more.toFixed(2)} more`,
      };
    case 'cost':
      return { ...NONE, value: `${needs.more.toFixed(2)} more of expected cost` };
    case 'window':
      return { ...NONE, window: 'one that closes later' };
    default:
      return { ...NONE, other: reasonText(reason) };
  }
}
