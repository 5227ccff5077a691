import { describe, expect, it } from 'vitest';
import type { Task } from '../../record/types';
import { counts, neighbour, type Row, rowsOf, slice, stateLabel, taskTable, tone, treeStep } from './view';

function task(
  id: number,
  parent: number | null,
  state: Task['state'] = 'ongoing',
  outcome: string | null = null,
): Task {
  const rest = {
    tag: `s${id}`,
    goal: `(goal ${id})`,
    since_ns: 0,
    created_ns: 0,
    method: null,
    targets: [],
    is_message: false,
    method_place: null,
    place: null,
  };
  return { id, parent, state, outcome, ...rest };
}

const tasks = [
  task(1, null),
  task(2, 1, 'terminated', 'success'),
  task(3, 1),
  task(4, 2, 'terminated'),
  task(5, 3),
];
const ids = (rows: { task: Task }[]) => rows.map(row => row.task.id);

describe('the tree', () => {
  it('folds away what has ended and keeps the written order', () => {
    const rows = rowsOf(tasks, new Map(), false);
    expect(ids(rows)).toEqual([1, 2, 3, 5]);
    expect(rows.map(row => row.depth)).toEqual([0, 1, 1, 2]);
    expect(rows[1]).toMatchObject({ children: 1, open: false });
  });

  it('obeys the hand, and opens everything while a filter is on', () => {
    const byHand = new Map([
      [2, true],
      [3, false],
    ]);
    expect(ids(rowsOf(tasks, byHand, false))).toEqual([1, 2, 4, 3]);
    expect(ids(rowsOf(tasks, byHand, true))).toEqual([1, 2, 4, 3, 5]);
  });

  it('shows a task whose parent was left out at the top', () => {
    expect(ids(rowsOf([task(7, 6)], new Map(), false))).toEqual([7]);
  });
});

describe('a row', () => {
  it('says how a task ended', () => {
    expect(stateLabel(task(1, null))).toBe('ongoing');
    expect(stateLabel(task(1, null, 'terminated', 'success'))).toBe('done');
    expect(stateLabel(task(1, null, 'terminated', 'failure'))).toBe('failed');
    for (const failure of ['precondition failed', 'invariant violated']) {
      expect(stateLabel(task(1, null, 'terminated', failure))).toBe('failed');
    }
    for (const outcome of ['cut', 'skipped', 'exited']) {
      expect(stateLabel(task(1, null, 'terminated', outcome))).toBe(outcome);
    }
    expect(stateLabel(task(1, null, 'terminated'))).toBe('ended');
    expect(tone(task(1, null, 'terminated', 'failure'))).toBe('failed');
  });

  it('moves by the keys of a tree', () => {
    const row = (id: number, depth: number, children: number, open: boolean): Row =>
      ({ task: { id }, depth, children, open }) as unknown as Row;
    const rows = [row(1, 0, 2, true), row(2, 1, 0, false), row(3, 1, 4, false)];
    const press = (key: string, selected: number | null) => {
      const step = treeStep(key, rows, selected);
      return step && ('to' in step ? step.to : `toggle ${step.toggle.task.id}`);
    };
    expect([press('Home', 3), press('End', 1)]).toEqual([1, 3]);
    expect([press('ArrowRight', 1), press('ArrowRight', 2), press('ArrowRight', 3)]).toEqual([
      2,
      2,
      'toggle 3',
    ]);
    expect([press('ArrowLeft', 3), press('ArrowLeft', 1)]).toEqual([1, 'toggle 1']);
    expect([press('ArrowDown', 1), press('ArrowUp', 3), press('Enter', 3)]).toEqual([2, 2, 'toggle 3']);
    expect([press('ArrowDown', null), press('n', 1)]).toEqual([1, null]);
  });

  it('has a neighbour', () => {
    const rows = rowsOf(tasks, new Map(), false);
    expect(neighbour(rows, 2, 1)).toBe(3);
    expect(neighbour(rows, 5, 1)).toBe(5);
    expect(neighbour(rows, 99, 1)).toBe(1);
    expect(neighbour([], null, 1)).toBeNull();
  });
});

it('only rows in sight are drawn', () => {
  expect(slice(0, 240, 24, 1000)).toEqual({ from: 0, to: 18 });
  expect(slice(2400, 240, 24, 105)).toEqual({ from: 92, to: 105 });
});

it('states without tasks are not counted', () => {
  expect(counts({ at_ns: 0, tasks: [], counts: { ongoing: 2, terminated: 1 }, left_out: 0 })).toEqual([
    { state: 'ongoing', count: 2 },
    { state: 'terminated', count: 1 },
  ]);
  expect(counts(null)).toEqual([]);
});

it('exports every task, folded or not', () => {
  const table = taskTable(tasks);
  expect(table[0]).toEqual(['task', 'parent', 'depth', 'state', 'outcome', 'tag', 'goal']);
  expect(table.slice(1).map(row => row[0])).toEqual([1, 2, 4, 3, 5]);
  expect(table[3]).toEqual([4, 2, 2, 'terminated', null, 's4', '(goal 4)']);
});
