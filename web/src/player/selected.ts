/** Selected events and plans: look-ups in the record by their numbers. Pure except for the source. */

import type { RecordSource } from '../record/source';
import type { EventRow } from '../record/types';
import type { Selection } from './address';

type Source = Pick<RecordSource, 'events' | 'plans'>;

/** The event with this number, also if it comes later than the cursor; null if the record has none. */
export async function eventNumbered(source: Source, number: number, endNs: number): Promise<EventRow | null> {
  const { events } = await source.events({
    fromNs: null,
    toNs: endNs,
    find: '',
    kinds: '',
    task: null,
    limit: 1,
    before: number + 1,
  });
  return events.find(event => event.id === number) ?? null;
}

/** A selected event or plan in the record: its instant, null if that is not known; or the reason why there is none. */
export type Found = { atNs: number | null } | { missing: string };

/**
 * Looks a selection up in the whole record. Only for an address: its user wants to go there, and everything else is shown as known at the
 * cursor's instant. Tasks and targets have no instant.
 */
export async function foundSelection(source: Source, selection: Selection, endNs: number): Promise<Found> {
  if (selection && 'event' in selection) {
    const event = await eventNumbered(source, selection.event, endNs);
    return event ? { atNs: event.t_ns } : { missing: `the record has no event ${selection.event}` };
  }
  if (selection && 'plan' in selection) {
    const { plans, left_out } = await source.plans(endNs);
    const plan = plans.find(one => one.number === selection.plan);
    if (plan) return { atNs: plan.adopted_ns };
    if (selection.plan > left_out || selection.plan < 1)
      return { missing: `the flight has no plan ${selection.plan}` };
  }
  return { atNs: null };
}

/** Words for a selected plan that is not among the plans shown; null if it is. */
export function missingPlan(
  number: number | null,
  plans: readonly { number: number }[],
  leftOut: number,
): string | null {
  if (number === null || plans.some(plan => plan.number === number)) return null;
  if (number >= 1 && number <= leftOut) return `Plan ${number} is older than the plans that are shown.`;
  return `No plan ${number} was adopted by this time.`;
}
