/** A drawn plan: the order of visits and the messages that commit it; pure. */

import type { Target } from '../../record/types';

/** `visits` with the one at `from` at another place. */
export function movedVisit(visits: readonly string[], from: number, by: 1 | -1): string[] {
  const list = [...visits];
  const [visit] = list.splice(from, 1);
  if (visit !== undefined) list.splice(Math.min(Math.max(from + by, 0), list.length), 0, visit);
  return list;
}

/** The messages that make the flight plan these visits, in this order. */
export function commitForms(visits: readonly string[]): string[] {
  return [`(plan-imposed (${visits.join(' ')}))`, '(off-schedule imposed-plan)'];
}

/** Targets that can still be visited and are not in the draft. */
export function addable(targets: readonly Target[], visits: readonly string[]): Target[] {
  return targets.filter(target => target.state !== 'observed' && !visits.includes(target.id));
}
