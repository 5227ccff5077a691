import { describe, expect, it } from 'vitest';
import { changesOf, changeWords, needsOf } from './plans';
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

// The reasons are those given by the planners in crates/solvers and crates/planning.
it('a reason fills the column that it is about, with the figures of the planner', () => {
  const column = (reason: string) => Object.entries(needsOf(reason)).filter(([, text]) => text !== '');
  expect(column('needs 33 s more than the end of the mission leaves')).toEqual([
    ['time', '33 s more than the end of the mission'],
  ]);
  expect(column('needs 12 min more than the end of the mission leaves, even alone')).toEqual([
    ['time', '12 min more than the end of the mission, even alone'],
  ]);
  expect(column('needs 179 s more than the horizon allows')).toEqual([
    ['time', '179 s more than the horizon'],
  ]);
  expect(
    column('needs 2 min more than the battery leaves: it has 40 min above its reserve of 11 min'),
  ).toEqual([['fuel', 'for 2 min more']]);
  expect(column('needs 7 s more than endurance leaves')).toEqual([['fuel', 'for 7 s more']]);
  expect(column('would lower the score by 0.42: the time it takes costs more than it is worth')).toEqual([
    ['value', 'at least 0.42 more'],
  ]);
  expect(
    column(
      'one visit on the way would raise the expected cost from 189.4910 to 193.7292: the others would wait longer',
    ),
  ).toEqual([['value', '4.24 more of expected cost']]);
  expect(
    column('does not fit between the others: its last time window closes before the vehicle can be there'),
  ).toEqual([['window', 'one that closes later']]);
  expect(column('inside restricted area Compressor station')).toEqual([
    ['other', 'inside restricted area Compressor station'],
  ]);
});
