import { describe, expect, it } from 'vitest';
import { changesOf, changeWords, needsOf, reasonText } from './plans';
import type { PlanInForce, VisitNeed } from './types';

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
    left_out: left.map(target => ({ target, reason: 'too far', needs: null })),
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

it('times of a minute and more have no seconds alone', () => {
  expect(reasonText('needs 101 s more than the horizon leaves')).toBe(
    'needs 1 min 41 s more than the horizon leaves',
  );
  expect(reasonText('needs 55 s more, at 1.5 s')).toBe('needs 55 s more, at 1.5 s');
  const [change] = changesOf(plan(2, 15, [['b', 20 + 932]], []), plan(1, 0, [['b', 20]], []));
  expect(change && changeWords(change)).toBe('15 h 32 min later');
});

it('what a target lacks fills the column that it is about, with the figures of the planner', () => {
  const column = (needs: VisitNeed | null, reason = '') =>
    Object.entries(needsOf({ needs, reason })).filter(([, text]) => text !== '');
  const time = { kind: 'time' as const, limit: 'the end of the mission', is_energy: false, alone: false };
  expect(column({ ...time, more_s: 33 })).toEqual([['time', '33 s more than the end of the mission']]);
  expect(column({ ...time, more_s: 720, alone: true })).toEqual([
    ['time', '12 min more than the end of the mission, even alone'],
  ]);
  expect(column({ ...time, more_s: 11_100 })).toEqual([
    ['time', '3 h 5 min more than the end of the mission'],
  ]);
  expect(column({ ...time, more_s: 101, limit: 'the horizon' })).toEqual([
    ['time', '1 min 41 s more than the horizon'],
  ]);
  expect(column({ ...time, more_s: 7, limit: 'endurance', is_energy: true })).toEqual([
    ['fuel', 'for 7 s more'],
  ]);
  expect(column({ kind: 'value', more: 0.42 })).toEqual([['value', 'at least 0.42 more']]);
  expect(column({ kind: 'value', more: null })).toEqual([['value', 'more than 0']]);
  expect(column({ kind: 'cost', more: 4.2382 })).toEqual([['value', '4.24 more of expected cost']]);
  expect(column({ kind: 'window' })).toEqual([['window', 'one that closes later']]);
  expect(column(null, 'inside restricted area Compressor station')).toEqual([
    ['other', 'inside restricted area Compressor station'],
  ]);
});
