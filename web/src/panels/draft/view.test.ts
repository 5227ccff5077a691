import { describe, expect, it } from 'vitest';
import { addable, commitForms, draftTable, movedVisit, withoutVisit } from './view';

describe('a draft', () => {
  it('moves visits within its ends', () => {
    expect(movedVisit(['a', 'b', 'c'], 2, -1)).toEqual(['a', 'c', 'b']);
    expect(movedVisit(['a', 'b'], 0, -1)).toEqual(['a', 'b']);
    expect(movedVisit(['a', 'b'], 9, 1)).toEqual(['a', 'b']);
  });

  it('keeps the other visits of a target when one of them is taken out', () => {
    expect(withoutVisit(['a', 'b', 'a'], 0)).toEqual(['b', 'a']);
    expect(withoutVisit(['a', 'b', 'a'], 2)).toEqual(['a', 'b']);
  });

  it('is committed by the messages that the mission plans by', () => {
    expect(commitForms(['a', 'b'])).toEqual(['(plan-imposed (a b))', '(off-schedule imposed-plan)']);
  });

  it('offers what is still to be observed', () => {
    const target = (id: string, state: string) => ({ id, state }) as never;
    expect(
      addable([target('a', 'planned'), target('b', 'observed'), target('c', 'skipped')], ['a']).map(
        one => one.id,
      ),
    ).toEqual(['c']);
  });
});

it('exports a draft with the times that a validated plan gives it', () => {
  const plan = { visits: [{ begin_ns: 60e9, end_ns: 90e9 }] } as never;
  expect(draftTable(['a', 'b'], plan)).toEqual([
    ['visit', 'target', 'begin_s', 'end_s'],
    [1, 'a', 60, 90],
    [2, 'b', null, null],
  ]);
  expect(draftTable(['a'], null)[1]).toEqual([1, 'a', null, null]);
});
