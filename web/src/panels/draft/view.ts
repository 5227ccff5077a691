/** A drawn plan: the order of visits and the messages that commit it; pure. */

import type { PlanInForce, Target } from '../../record/types';
import { NANOSECONDS_PER_SECOND } from '../../time/format';

/** `visits` with the visit at `from` moved to another position. */
export function movedVisit(visits: readonly string[], from: number, by: 1 | -1): string[] {
  const list = [...visits];
  const [visit] = list.splice(from, 1);
  if (visit !== undefined) list.splice(Math.min(Math.max(from + by, 0), list.length), 0, visit);
  return list;
}

/** `visits` without the one at `index`; other visits of the same target stay. */
export function withoutVisit(visits: readonly string[], index: number): string[] {
  return visits.filter((_, at) => at !== index);
}

/** The messages that make the flight plan exactly these visits, in this order. */
export function commitForms(visits: readonly string[]): string[] {
  return [`(plan-imposed (${visits.join(' ')}))`, '(off-schedule imposed-plan)'];
}

/** Targets that can still be visited and are not in the draft. */
export function addable(targets: readonly Target[], visits: readonly string[]): Target[] {
  return targets.filter(target => target.state !== 'observed' && !visits.includes(target.id));
}

/** The draft as a table: visits, with the times of the validated plan if there is one. */
export function draftTable(
  visits: readonly string[],
  plan: PlanInForce | null,
): (string | number | null)[][] {
  const rows = visits.map((target, index) => {
    const visit = plan?.visits[index];
    const times = visit
      ? [visit.begin_ns, visit.end_ns].map(ns => ns / NANOSECONDS_PER_SECOND)
      : [null, null];
    return [index + 1, target, ...times];
  });
  return [['visit', 'target', 'begin_s', 'end_s'], ...rows];
}
