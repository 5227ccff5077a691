import { describe, expect, it } from 'vitest';
import { changesOf, changeWords } from './plans';
import type { PlanInForce } from './types';

const MINUTE = 60e9;
function plan(number: number, adopted: number, visits: [string, number][], left: string[]): PlanInForce {
  return {
    number,
    adopted_ns: adopted * MINUTE,
    summary: '',
    route: [],
    visits: visits.map(([target, begin]) => ({
      target,
      begin_ns: begin * MINUTE,
      end_ns: (begin + 1) * MINUTE,
    })),
    left_out: left.map(target => ({ target, reason: 'too far' })),
  };
}

describe('what a plan changed', () => {
  const first = plan(
    1,
    0,
    [
      ['a', 10],
      ['b', 20],
      ['c', 30],
      ['d', 40],
    ],
    ['e'],
  );
  it('is all of it for the first plan', () => {
    expect(changesOf(first, null)).toHaveLength(5);
  });
  it('is what moved, came, went or is left out, and no visit that is over', () => {
    const second = plan(
      2,
      15,
      [
        ['c', 20],
        ['b', 33],
        ['d', 40],
        ['f', 50],
      ],
      ['e', 'g'],
    );
    const words = changesOf(second, first).map(change => [change.target, changeWords(change)]);
    expect(words).toEqual([
      ['c', '10 min earlier'],
      ['b', '13 min later'],
      ['f', 'added'],
      ['g', 'left out'],
    ]);
    const dropped = changesOf(plan(3, 15, [['b', 20]], []), first).map(change => [
      change.target,
      changeWords(change),
    ]);
    expect(dropped).toEqual([
      ['c', 'dropped'],
      ['d', 'dropped'],
    ]);
  });
});
