import { describe, expect, it } from 'vitest';
import type { PlanInForce, Target } from '../../record/types';
import {
  addable,
  commitForms,
  draftTable,
  missedWords,
  movedVisit,
  openPart,
  underWayWords,
  withoutVisit,
} from './view';

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

  it('has the visits of a plan that are not over, with the one under way first', () => {
    const visit = (target: string, at: number) => ({ target, begin_ns: at * 1e9, end_ns: (at + 40) * 1e9 });
    const plan = {
      adopted_ns: 900e9,
      visits: [visit('depot', 986), visit('camp', 1197), visit('school', 1323), visit('camp', 1863)],
    } as unknown as PlanInForce;
    const target = (id: string, state: string, history: [string, number][]): Target =>
      ({
        id,
        name: id,
        state,
        history: history.map(([state, t]) => ({ state, t_ns: t * 1e9 })),
      }) as unknown as Target;
    const targets = (camp: [string, number][], school: [string, number][] = []) => [
      target('depot', 'observed', [
        ['observing', 993],
        ['observed', 1053],
      ]),
      target('camp', camp.at(-1)?.[0] ?? 'planned', camp),
      target('school', school.at(-1)?.[0] ?? 'planned', school),
    ];
    // Its planned begin is past, but nothing of it has been flown.
    const late = openPart(plan, targets([]), 1200e9);
    expect([late.visits, late.underWay]).toEqual([['camp', 'school', 'camp'], 'camp']);
    const observing = openPart(plan, targets([['observing', 1211]]), 1220e9);
    expect([observing.visits, observing.underWay]).toEqual([['camp', 'school', 'camp'], 'camp']);
    const over = openPart(
      plan,
      targets([
        ['observing', 1211],
        ['observed', 1250],
      ]),
      1260e9,
    );
    expect([over.visits, over.underWay]).toEqual([['school', 'camp'], null]);
    const later = openPart(plan, targets([], [['observing', 1330]]), 1340e9);
    expect([later.visits, later.underWay]).toEqual([['school', 'camp'], 'school']);
    expect(missedWords(later.missed, one => one)).toBe(
      'Not flown, and not in the draft: camp, planned 0:19:57.',
    );
  });

  it('says when it takes the vehicle away from the visit under way', () => {
    const said = (draft: string[], underWay: string | null = 'camp') =>
      underWayWords(underWay, draft, one => one);
    expect(said(['camp', 'school'])?.isLost).toBe(false);
    expect(said(['school'])).toMatchObject({
      isLost: true,
      words: expect.stringContaining('is not in this draft'),
    });
    expect(said(['school', 'camp'])?.words).toContain('is not the first visit');
    expect(said(['school'], null)).toBeNull();
  });

  it('offers what is still to be observed', () => {
    const target = (id: string, state: string) => ({ id, state, gone_ns: null }) as never;
    const gone = { id: 'd', state: 'skipped', gone_ns: 10 } as never as Target;
    expect(
      addable([target('a', 'planned'), target('b', 'observed'), target('c', 'skipped'), gone], ['a']).map(
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
