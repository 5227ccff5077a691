/** The task tree as rows to draw; pure. */

import type { Task, TaskState, Tasks } from '../../record/types';
import { isFailure } from '../../words/state';

export interface Row {
  task: Task;
  depth: number;
  children: number;
  open: boolean;
}

/** Tasks that the user opened (true) or closed (false), in place of the default. */
export type Toggled = ReadonlyMap<number, boolean>;

export const STATES: readonly TaskState[] = ['pending', 'enabled', 'ongoing', 'interrupted', 'terminated'];

/** The tree in reading order; closed branches are left out. While a filter is on, all branches are open. */
export function rowsOf(tasks: readonly Task[], toggled: Toggled, filtering: boolean): Row[] {
  const known = new Set(tasks.map(task => task.id));
  const children = new Map<number | null, Task[]>();
  for (const task of tasks) {
    const parent = task.parent !== null && known.has(task.parent) ? task.parent : null;
    const list = children.get(parent);
    if (list) list.push(task);
    else children.set(parent, [task]);
  }
  const rows: Row[] = [];
  const open: { task: Task; depth: number }[] = (children.get(null) ?? [])
    .map(task => ({ task, depth: 0 }))
    .reverse();
  for (let next = open.pop(); next; next = open.pop()) {
    const { task, depth } = next;
    const below = children.get(task.id) ?? [];
    const isOpen = below.length > 0 && (filtering || (toggled.get(task.id) ?? opensByItself(task, depth)));
    rows.push({ task, depth, children: below.length, open: isOpen });
    if (isOpen) for (const child of below.toReversed()) open.push({ task: child, depth: depth + 1 });
  }
  return rows;
}

/** By default the root and all tasks that have not ended are open, and ended tasks are closed. */
function opensByItself(task: Task, depth: number): boolean {
  return depth === 0 || task.state !== 'terminated';
}

/** The word for a task's state, or for its outcome once it has ended. */
export function stateLabel(task: Task): string {
  if (task.state !== 'terminated') return task.state;
  if (isFailure(task.outcome)) return 'failed';
  return task.outcome === 'success' ? 'done' : (task.outcome ?? 'ended');
}

/** The colour's name for a task: failures are emphasised among ended tasks. */
export function tone(task: Task): string {
  return stateLabel(task) === 'failed' ? 'failed' : task.state;
}

/** The tasks with an interrupted child. */
export function holdingInterrupted(tasks: readonly Task[]): Set<number | null> {
  return new Set(tasks.filter(task => task.state === 'interrupted').map(task => task.parent));
}

/** `12 ongoing`, for the states that some task is in. */
export function counts(tasks: Tasks | null): { state: TaskState; count: number }[] {
  return STATES.flatMap(state => {
    const count = tasks?.counts[state] ?? 0;
    return count > 0 ? [{ state, count }] : [];
  });
}

/** The part of a long list that is in sight, with a margin. */
export function slice(
  scrollTop: number,
  height: number,
  rowHeight: number,
  count: number,
): { from: number; to: number } {
  const margin = 8;
  const from = Math.max(0, Math.floor(scrollTop / rowHeight) - margin);
  return { from, to: Math.min(count, Math.ceil((scrollTop + height) / rowHeight) + margin) };
}

/** The task at the distance of `by` rows from the selected one. */
export function neighbour(rows: readonly Row[], selected: number | null, by: 1 | -1): number | null {
  const at = rows.findIndex(row => row.task.id === selected);
  if (at < 0) return rows[0]?.task.id ?? null;
  return rows[Math.min(Math.max(at + by, 0), rows.length - 1)]?.task.id ?? null;
}

/**
 * What a key does in the tree: the task that it selects, or the row that it opens or closes; null for other keys. Right opens a row, then
 * goes to its first child; left closes it, then goes to the task above.
 */
export function treeStep(
  key: string,
  rows: readonly Row[],
  selected: number | null,
): { to: number | null } | { toggle: Row } | null {
  const at = rows.findIndex(row => row.task.id === selected);
  const row = rows[at];
  const id = (index: number) => ({ to: rows[index]?.task.id ?? null });
  switch (key) {
    case 'ArrowDown':
      return { to: neighbour(rows, selected, 1) };
    case 'ArrowUp':
      return { to: neighbour(rows, selected, -1) };
    case 'Home':
      return id(0);
    case 'End':
      return id(rows.length - 1);
    case 'ArrowRight':
      if (!row) return id(0);
      if (row.children === 0) return { to: selected };
      return row.open ? id(at + 1) : { toggle: row };
    case 'ArrowLeft':
      if (!row) return id(0);
      if (row.open) return { toggle: row };
      return { to: rows.slice(0, at).findLast(other => other.depth < row.depth)?.task.id ?? selected };
    case 'Enter':
    case ' ':
      return row && row.children > 0 ? { toggle: row } : { to: selected };
    default:
      return null;
  }
}

/** The tasks as a table, in reading order with their depth, including those in closed branches. */
export function taskTable(tasks: readonly Task[]): (string | number | null)[][] {
  const rows = rowsOf(tasks, new Map(), true);
  const head = ['task', 'parent', 'depth', 'state', 'outcome', 'tag', 'goal'];
  return [
    head,
    ...rows.map(({ task, depth }) => [
      task.id,
      task.parent,
      depth,
      task.state,
      task.outcome,
      task.tag,
      task.goal,
    ]),
  ];
}
