import { describe, expect, it } from 'vitest';
import type { Holdings, PlanInForce } from '../../record/types';
import { causeWords, endWords, nextWords, reasonWords, taskAtWork, tasksAbove, whatWords } from './view';

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
    expect(causeWords('the episode holds for P6.03S: (observe zaca)', names)).toBe(
      'the episode holds for 6.03 s: observe Zaca',
    );
    expect(causeWords('', names)).toBe('');
  });

  it('names the condition or the plan behind a task that was granted what it needs', () => {
    const moment = (id: number, to: string, kind: string, observed: string) => ({
      id,
      to,
      because: '',
      cause: { kind, observed },
    });
    const answer = (enabled: [string, string]) => ({
      cause: 'it was granted flight-path',
      task: { goal: '(scan zaca once along ((34.3 ..)))', targets: ['zaca'] },
      explanation: {
        history: [moment(1, 'enabled', ...enabled), moment(2, 'ongoing', 'resources-granted', '')],
      },
    });
    const plan = { number: 2, adopted_ns: 21_585e9, visits: [{ target: 'zaca' }] } as never;
    const because = (enabled: [string, string], inForce: PlanInForce | null = plan) =>
      reasonWords(answer(enabled) as never, inForce, names);
    const free: [string, string] = ['no-preconditions', ''];
    expect(because(free)).toBe('plan 2, adopted 5:59:45, has Zaca');
    expect(because(free, null)).toBe('it was granted flight-path');
    // A task without a target serves a task above it that has one.
    const hovering = { goal: '(hover)', targets: [] };
    const hover = { ...answer(free), task: hovering };
    const above = [
      { goal: '(orient camera-1)', targets: [] },
      { goal: '(visit zaca with camera-1)', targets: ['zaca'] },
    ];
    expect(reasonWords(hover as never, plan, names, above)).toBe('plan 2, adopted 5:59:45, has Zaca');
    expect(whatWords(hovering, names, above)).toBe('hover, to visit Zaca');
    expect(whatWords({ goal: '(scan zaca)', targets: ['zaca'] }, names, above)).toBe('scan Zaca');
    expect(whatWords(hovering, names, above.slice(0, 1))).toBe('hover');
    const tree = [3, 2, 1].map(id => ({ id, parent: id === 1 ? null : id - 1, goal: `(g${id})` })) as never;
    expect(tasksAbove(tree, { parent: 2 }).map(task => task.goal)).toEqual(['(g2)', '(g1)']);
    const rolled: [string, string] = ['preconditions-satisfied', 'roll above 3deg for P6S'];
    expect(because(rolled)).toBe('roll above 3deg for 6 s');
  });

  it('names ended tasks and messages without numbers of tasks', () => {
    const because = (...evidence: unknown[]) => {
      const enabled = {
        id: 1,
        to: 'enabled',
        because: '',
        cause: { kind: 'preconditions-satisfied', evidence, observed: 'T5 ended at 0:53:04.689' },
      };
      const began = { id: 2, to: 'ongoing', because: '', cause: { kind: 'resources-granted' } };
      const answer = {
        cause: '',
        task: { goal: '(hover)', targets: [] },
        explanation: { history: [enabled, began] },
      };
      const goals = new Map([[5, '(power-up camera-1)']]);
      return reasonWords(answer as never, null, names, [], task => goals.get(task) ?? null);
    };
    const end = (task: number, at: number) => ({
      type: 'task-end',
      task: `T${task}`,
      task_number: task,
      at,
    });
    expect(because(end(4, 3127.689), end(5, 3184.689))).toBe('power up camera 1 ended at 0:53:04');
    expect(because(end(4, 45))).toBe('the step before it ended at 0:00:45');
    const event = {
      type: 'event',
      form: '(segment-weighed zaca (1 2) again 0.4 "the segment")',
      at: 49_445.4,
    };
    expect(because(event)).toBe('segment weighed Zaca at 13:44:05');
    const sample = { type: 'sample', variable: '(roll uav)', value: '4deg', at: 3 };
    expect(because(sample, end(5, 4))).toBe('T5 ended at 0:53:04');
  });

  it('names the visit after the last one begun, also if it is late or planned again', () => {
    const visit = (target: string, begin_s: number) => ({ target, begin_ns: begin_s * 1e9, end_ns: 0 });
    const plan = {
      adopted_ns: 100e9,
      visits: [visit('zaca', 110), visit('lick', 34_500), visit('zaca', 36_000)],
    } as unknown as PlanInForce;
    const change = (state: string, t_s: number) => ({ state, t_ns: t_s * 1e9, detail: null });
    const next = (atS: number, zaca: unknown[], lick: unknown[] = []) => {
      const targets = [
        { id: 'zaca', name: 'Zaca', history: zaca },
        { id: 'lick', name: 'Lick', history: lick },
      ];
      return nextWords(plan, targets as never, atS * 1e9);
    };
    expect(next(101, [])).toBe('Zaca, planned 0:01');
    // Nothing has begun, though the planned time of the first visit is over.
    expect(next(35_000, [change('observed', 50)])).toBe('Zaca, planned 0:01');
    const observed = [change('observing', 120), change('observed', 130)];
    expect(next(125, observed)).toBe('Lick, planned 9:35');
    expect(next(200, observed, [change('observing', 190)])).toBe('Zaca, planned 10:00');
    // The visit under way when the plan is adopted is its first one, and is not counted twice.
    const going = [change('observing', 90), change('planned', 100), change('observing', 105)];
    expect(next(106, going)).toBe('Lick, planned 9:35');
    expect(next(200, [...going, change('observed', 140), change('observing', 190)])).toBe('');
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
