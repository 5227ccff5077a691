import { describe, expect, it } from 'vitest';
import type { Holdings, PlanInForce } from '../../record/types';
import { causeWords, endWords, nextWords, taskAtWork } from './view';

const names = new Map([['zaca', 'Zaca']]);

describe('the now line', () => {
  it('names the holder of the flight path at the instant, not a later one', () => {
    const held = (task: number, from_ns: number, to_ns: number) => ({
      task,
      amount: null,
      from_ns,
      to_ns,
      open: false,
    });
    const holdings: Holdings = {
      resources: [
        { resource: 'camera', left_out: 0, holdings: [held(9, 0, 99)] },
        { resource: 'flight-path', left_out: 0, holdings: [held(1, 0, 99), held(4, 10, 20)] },
      ],
    };
    expect(taskAtWork(holdings, [], 15)).toBe(4);
    expect(taskAtWork(holdings, [], 30)).toBe(1);
    expect(taskAtWork(null, [], 30)).toBeNull();
  });

  it('states the cause', () => {
    expect(causeWords('T3 is ongoing because the episode holds for P6.03S: (observe zaca)', names)).toBe(
      'the episode holds for 6.03 s: observe Zaca',
    );
    expect(causeWords('T3 is pending: it waits', names)).toBe('');
  });

  it('names the next visit after the instant', () => {
    const plan = {
      visits: [
        { target: 'a', begin_ns: 1, end_ns: 2 },
        { target: 'zaca', begin_ns: 34_500e9, end_ns: 3 },
      ],
    };
    const target = { id: 'zaca', name: 'Zaca' } as never;
    expect(nextWords(plan as unknown as PlanInForce, [target], 5)).toBe('Zaca, planned 9:35');
    expect(nextWords(null, [], 0)).toBe('');
  });

  it('says that a flight failed', () => {
    expect(endWords({ ending: { reason: 'out of fuel', failed: true } } as never)).toEqual({
      words: '▲ failed: out of fuel',
      failed: true,
    });
    expect(endWords({ ending: null } as never)).toBeNull();
  });
});
