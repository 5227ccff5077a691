import { describe, expect, it } from 'vitest';
import type { ProcedureRow, Task } from '../../record/types';
import { type Activity, layOut, planActivities, procedureActivities } from './view';

const activity = (id: string, after: string[], seconds = 0): Activity => ({
  id,
  words: id,
  glyph: '·',
  note: '',
  title: '',
  task: null,
  target: null,
  place: null,
  after,
  seconds,
});

describe('the network of activities', () => {
  it('places each activity after all that it waits for, and marks the longest path', () => {
    const { nodes, edges } = layOut(
      [activity('a', [], 5), activity('b', ['a'], 9), activity('c', ['a'], 1), activity('d', ['b', 'c'], 2)],
      9,
    );
    const x = Object.fromEntries(nodes.map(node => [node.id, node.x]));
    expect((x.a ?? 0) < (x.b ?? 0) && x.b === x.c && (x.c ?? 0) < (x.d ?? 0)).toBe(true);
    expect(nodes.filter(node => node.critical).map(node => node.id)).toEqual(['a', 'b', 'd']);
    expect(edges).toHaveLength(4);
    expect(edges.filter(edge => edge.critical)).toHaveLength(2);
  });

  it('ends on circles', () => {
    expect(layOut([activity('a', ['b'], 1), activity('b', ['a'], 1)], 9).nodes).toHaveLength(2);
  });

  it('takes states and times from the tasks of the parent', () => {
    const step = {
      tag: 's',
      activity: '(go)',
      place: 'p:1:1',
      after: [],
      waits: [],
      repeats: false,
      ends: false,
    };
    const row: ProcedureRow = {
      kind: 'procedure',
      index: '(x)',
      place: 'p:0:1',
      order: 'concurrent',
      steps: [step],
    };
    const task: Task = {
      id: 7,
      parent: 3,
      tag: 's',
      goal: '(go home)',
      state: 'terminated',
      outcome: 'failure',
      since_ns: 70e9,
      created_ns: 10e9,
      method: null,
      targets: [],
      is_message: false,
      method_place: null,
      place: 'p:1:1',
    };
    const [one] = procedureActivities(row, [task], 3, 99e9, new Map());
    expect([one?.glyph, one?.words, one?.note, one?.seconds]).toEqual([
      '▲',
      'go home',
      '0:00:10–0:01:10',
      60,
    ]);
    expect(procedureActivities(row, [task], 4, 99e9, new Map())[0]?.glyph).toBe('·');
  });

  it('shows planned next to flown', () => {
    const plan = {
      number: 1,
      adopted_ns: 0,
      summary: '',
      route: [],
      left_out: [],
      visits: [{ target: 'a', begin_ns: 3600e9, end_ns: 3700e9 }],
    };
    const target = {
      id: 'a',
      name: 'Ahorn',
      latitude_deg: null,
      longitude_deg: null,
      value: null,
      geometry: null,
      state: 'observed',
      since_ns: 0,
      detail: null,
      announced_ns: null,
      history: [{ t_ns: 3660e9, state: 'observing', detail: null }],
    } as never;
    expect(planActivities(plan, [target], 4000e9)[0]?.note).toBe('planned 1:00:00, flown 1:01:00');
    expect(planActivities(plan, [target], 3000e9)[0]?.note).toBe('planned 1:00:00');
  });
});
