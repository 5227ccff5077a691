import { describe, expect, it } from 'vitest';
import type { Holdings, PlanInForce, Report, Target } from '../../record/types';
import { leftWords, shownState, targetRows, visitsOf } from '../../record/visits';
import { resourceRows } from './rows';
import { NAMES_PX, scaleOf } from './view';

function target(id: string, history: [number, string][]): Target {
  return {
    id,
    name: id.toUpperCase(),
    value: 10,
    state: history.at(-1)?.[1] ?? null,
    detail: null,
    gone_ns: null,
    observed_ns: history.findLast(([, state]) => state === 'observed')?.[0] ?? null,
    history: history.map(([t_ns, state]) => ({ t_ns, state, detail: null })),
  } as unknown as Target;
}

function plan(
  number: number,
  adopted_ns: number,
  begins: Record<string, number>,
  left: string[],
): PlanInForce {
  return {
    number,
    adopted_ns,
    summary: '',
    route: [],
    visits: Object.entries(begins).map(([id, begin_ns]) => ({ target: id, begin_ns, end_ns: begin_ns + 1 })),
    left_out: left.map(id => ({ target: id, reason: 'no time', needs: null })),
  };
}

describe('rows of targets', () => {
  const known = {
    targets: [
      target('b', [[0, 'planned']]),
      target('a', [
        [0, 'planned'],
        [50, 'observing'],
        [70, 'observed'],
      ]),
    ],
    plans: [plan(1, 0, { a: 40, b: 60 }, []), plan(2, 30, { a: 50 }, ['b']), plan(3, 90, { b: 95 }, [])],
    troubles: [
      {
        t_ns: 60,
        kind: 'interrupted' as const,
        subject: '',
        cause: '',
        task: 1,
        failed_child: null,
        handler_task: null,
        targets: [],
        cause_kind: null,
        handler: null,
        place: null,
        target: null,
      },
    ],
    facts: {
      kind: 'fixed-wing' as const,
      duration_ns: 100,
      landing_distance_m_max: null,
      windows: [{ target: 'a', look: 'x', from_ns: 5, to_ns: 80 }],
    },
    report: null,
    atNs: 80,
  };
  it('show planned times of every plan so far, visits, and why a plan leaves a target out', () => {
    const [a, b] = targetRows(known);
    expect(a?.threads.map(thread => [thread.plan, thread.beginNs, thread.last])).toEqual([
      [1, 40, false],
      [2, 50, true],
    ]);
    expect(a?.visits).toEqual([{ fromNs: 50, toNs: 70, state: 'observed' }]);
    expect(a?.reflies).toEqual([60]);
    expect(a?.windows).toEqual([{ fromNs: 5, toNs: 80 }]);
    expect(b?.threads.at(-1)).toEqual({
      plan: 2,
      beginNs: null,
      reason: 'no time',
      last: true,
      begun: false,
    });
    expect(b?.words).toContain('left out since 0:00:00: no time');
  });
  it('show all visits of the plan in force, and the time of the next one', () => {
    const visits = [60, 100, 140].map(begin_ns => ({ target: 'a', begin_ns, end_ns: begin_ns + 1 }));
    const plans = [plan(1, 0, { a: 40 }, []), { ...plan(2, 30, {}, []), visits }];
    const rowAt = (atNs: number) => {
      const history: [number, string][] = [
        [30, 'planned'],
        [62, 'observing'],
        [70, 'observed'],
      ];
      const targets = [
        target(
          'a',
          history.filter(([since]) => since <= atNs),
        ),
      ];
      return targetRows({ ...known, targets, plans, atNs })[0];
    };
    expect(rowAt(50)?.threads.map(thread => thread.beginNs)).toEqual([40, 60, 100, 140]);
    // The circle of a visit that has begun would look like the sign of `observing` on the bar of the visit.
    expect(rowAt(65)?.threads.map(thread => thread.begun)).toEqual([false, true, false, false]);
    expect([50, 61, 65, 80].map(atNs => rowAt(atNs)?.nextNs)).toEqual([60, 60, 100, 100]);
    expect(rowAt(80)?.words).toContain('planned T+0:00:00');
  });
  it('have factors and worth of the report, by the identifier of the target instead of its name', () => {
    const flown = {
      id: 'a',
      target: 'Some Fire',
      coverage: { factor: 0.5, cause: 'not seen' },
      timing: { factor: 1, cause: '' },
      worth: 4.96,
    };
    const report = { t_ns: 80, sections: [{ section: 'score', body: { targets: [flown] } }] };
    const rows = targetRows({ ...known, report: report as unknown as Report });
    const [a, b] = [rows.find(row => row.id === 'a'), rows.find(row => row.id === 'b')];
    expect(a?.factors.map(factor => [factor.name, factor.value])).toEqual([
      ['coverage', 0.5],
      ['timing', 1],
    ]);
    expect(a?.words).toContain('worth 5.0 of 10, coverage 0.50');
    expect(b?.words).toContain('worth up to 10');
  });
  it('keep a target observed when later plans visit it again or leave it out', () => {
    const shown = (...last: [number, string][]) =>
      shownState(target('a', [[1, 'observing'], [2, 'observed'], ...last]));
    expect([shown(), shown([3, 'skipped']), shown([3, 'planned'])]).toEqual(Array(3).fill('observed'));
    expect(shown([3, 'planned'], [4, 'observing'])).toBe('observing');
    expect(shownState({ ...target('a', [[2, 'observed']]), gone_ns: 3 })).toBe('skipped');
    // The reason's words alone do not make it so.
    const worded = { ...target('a', [[2, 'observed']]), detail: 'no longer a target' };
    expect(shownState(worded)).toBe('observed');
    expect(shownState(target('a', []))).toBe('known');
  });
  it('have one visit where a plan was made during it', () => {
    const during = target('a', [
      [10, 'observing'],
      [20, 'planned'],
      [22, 'observing'],
      [30, 'observed'],
    ]);
    expect(visitsOf([during], 99).map(visit => [visit.fromNs, visit.toNs, visit.state])).toEqual([
      [10, 30, 'observed'],
    ]);
  });
  it('say since which plan a target is left out with the reason of that plan, and a later reason with its own plan', () => {
    const plans = [1, 2, 3].map(number => {
      const begins: Record<string, number> = number === 1 ? { b: 60 } : {};
      const made = plan(number, 10 * number, begins, number === 1 ? [] : ['b']);
      return { ...made, left_out: made.left_out.map(one => ({ ...one, reason: `reason ${number}` })) };
    });
    const row = (atNs: number) => targetRows({ ...known, plans, atNs }).find(one => one.id === 'b');
    expect(row(15)?.left).toBeNull();
    expect(row(25)?.left).toEqual({ sinceNs: 20, reason: 'reason 2', later: null });
    const later = row(35)?.left;
    expect(later).toEqual({ sinceNs: 20, reason: 'reason 2', later: { sinceNs: 30, reason: 'reason 3' } });
    expect(later && leftWords(later)).toBe('left out since 0:00:00: reason 2; since 0:00:00: reason 3');
    expect(row(35)?.words).toContain('left out since 0:00:00: reason 2; since');
  });
  it('show no target as planned that the plan in force does not mention', () => {
    const plans = [plan(1, 0, { a: 40, b: 60 }, ['c']), plan(2, 70e9, {}, [])];
    const passed = target('b', [[0, 'planned']]);
    const closed = target('c', [[0, 'skipped']]);
    const rows = targetRows({ ...known, targets: [passed, closed], plans, atNs: 80e9 });
    expect(rows.map(row => [row.state, row.left, row.nextNs])).toEqual(Array(2).fill(['known', null, null]));
    expect(rows[0]?.words).toContain('B, known, not in plan 2 of 0:01:10');
    expect(shownState(passed, plan(2, 70e9, { b: 90 }, []))).toBe('planned');
    expect(shownState(closed, plan(2, 70e9, {}, ['c']))).toBe('skipped');
    // A state that was recorded after the plan is not the plan's.
    expect(shownState(target('c', [[75e9, 'skipped']]), plan(2, 70e9, {}, []))).toBe('skipped');
  });
  it('name the last visit and the number of visits', () => {
    const changes: [number, string][] = [
      [10e9, 'observing'],
      [20e9, 'observed'],
      [50e9, 'observing'],
    ];
    const words = (count: number, atNs: number) =>
      targetRows({
        ...known,
        targets: [target('a', changes.slice(0, count))],
        plans: [],
        troubles: [],
        atNs,
      })[0]?.words;
    expect(words(1, 15e9)).toContain('visited since T+0:00:10');
    expect(words(2, 30e9)).toContain('visited T+0:00:10 to T+0:00:20');
    expect(words(3, 80e9)).toContain('2 visits, last since T+0:00:50');
  });
  it('say since when a target is none any longer, whatever plans said before', () => {
    const gone = { ...target('b', [[30, 'skipped']]), gone_ns: 3600e9 };
    const [row] = targetRows({ ...known, targets: [gone], atNs: 4000e9 });
    expect(row?.goneNs).toBe(3600e9);
    expect(row?.words).toContain('no longer a target since T+1:00:00');
    expect(row?.words).not.toContain('left out');
  });
  it('mark an observation without a visit at its instant', () => {
    const [row] = targetRows({
      ...known,
      targets: [target('a', [[50, 'observed']])],
      plans: [],
      troubles: [],
    });
    expect(row?.visits).toEqual([{ fromNs: 50, toNs: 50, state: 'observed' }]);
    expect(row?.words).toContain('observed T+0:00:00');
  });
});

describe('rows of resources', () => {
  const holdings: Holdings = {
    resources: [
      {
        resource: 'flight-path',
        left_out: 0,
        holdings: [
          { task: 1, amount: null, from_ns: 0, to_ns: 40, open: false },
          ...Array.from({ length: 5 }, (_, index) => ({
            task: 2 + index,
            amount: null,
            from_ns: 40 + index * 0.01,
            to_ns: 40.01 + index * 0.01,
            open: false,
          })),
          { task: 9, amount: '2', from_ns: 60, to_ns: 100, open: true },
        ],
      },
    ],
  };
  it('merge what is narrower than a pixel and count it', () => {
    const visible = { fromNs: 0, toNs: 100 };
    const [row] = resourceRows(holdings, visible, 100, scaleOf(visible, NAMES_PX + 100), () => 'fly');
    expect(row?.bars.map(bar => [bar.task, bar.count])).toEqual([
      [1, 1],
      [2, 5],
      [9, 1],
    ]);
    expect(row?.bars.at(-1)?.words).toBe('2, T9 fly');
    expect(row?.holder).toBe('T9 fly');
    // A holding that ended at the instant is over, as at the end of a flight.
    const ended = { task: 3, amount: null, from_ns: 10, to_ns: 50, open: false };
    const one: Holdings = { resources: [{ resource: 'flight-path', left_out: 0, holdings: [ended] }] };
    const holderAt = (atNs: number) =>
      resourceRows(one, visible, atNs, scaleOf(visible, 300), () => 'fly')[0]?.holder;
    expect([holderAt(49), holderAt(50)]).toEqual(['T3 fly', 'free']);
    expect(resourceRows(holdings, visible, 45, scaleOf(visible, 300), () => '')[0]?.holder).toBe('free');
  });
});
