import { expect, it } from 'vitest';
import type { EventsQuery } from '../record/source';
import type { EventRow, PlanInForce } from '../record/types';
import { eventNumbered, foundSelection, missingPlan } from './selected';

/** A record with the events 3, 5 and 9, whose instants are their numbers in seconds, and the plans 11 and 12 after ten older ones. */
const source = {
  async events({ before, limit }: EventsQuery) {
    const all = [3, 5, 9].map(id => ({ id, t_ns: id * 1e9 }) as EventRow);
    const events = all.filter(event => event.id < (before ?? Number.POSITIVE_INFINITY)).slice(-limit);
    return { events, more: false, next: null };
  },
  async plans() {
    return {
      plans: [11, 12].map(number => ({ number, adopted_ns: number * 1e9 }) as PlanInForce),
      left_out: 10,
    };
  },
};

it('an event is found by its number alone', async () => {
  expect((await eventNumbered(source, 5, 20e9))?.t_ns).toBe(5e9);
  expect(await eventNumbered(source, 6, 20e9)).toBeNull();
  expect(await eventNumbered(source, 1, 20e9)).toBeNull();
});

it('the selection of an address has an instant, or words why the record does not have it', async () => {
  expect(await foundSelection(source, { event: 9 }, 20e9)).toEqual({ atNs: 9e9 });
  expect(await foundSelection(source, { event: 10 }, 20e9)).toEqual({
    missing: 'the record has no event 10',
  });
  expect(await foundSelection(source, { plan: 12 }, 20e9)).toEqual({ atNs: 12e9 });
  expect(await foundSelection(source, { plan: 13 }, 20e9)).toEqual({ missing: 'the flight has no plan 13' });
  expect(await foundSelection(source, { plan: 0 }, 20e9)).toEqual({ missing: 'the flight has no plan 0' });
  // An older plan exists, but the answer does not list it.
  expect(await foundSelection(source, { plan: 4 }, 20e9)).toEqual({ atNs: null });
  expect(await foundSelection(source, { task: 4 }, 20e9)).toEqual({ atNs: null });
});

it('a plan that is not shown is explained', () => {
  const plans = [{ number: 3 }, { number: 4 }];
  expect(missingPlan(4, plans, 2)).toBeNull();
  expect(missingPlan(null, plans, 2)).toBeNull();
  expect(missingPlan(2, plans, 2)).toBe('Plan 2 is older than the plans that are shown.');
  expect(missingPlan(5, plans, 2)).toBe('No plan 5 was adopted by this time.');
});
