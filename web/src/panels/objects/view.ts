/** The object tree: agents, procedures, resources, monitors, variables; pure. */

import type { TreeNode } from '../../parts/rows';
import { holdsOf } from '../../record/conditions';
import type {
  Holdings,
  Monitors,
  ProcedureRow,
  ProgramContents,
  ShelfRow,
  Signals,
  Tasks,
} from '../../record/types';
import { missionTime } from '../../time/format';
import { type Names, phrase } from '../../words/phrase';

export type Thing =
  | { kind: 'record'; id: number }
  | { kind: 'place'; place: string }
  | { kind: 'task'; task: number }
  | { kind: 'signal'; name: string };

export interface Things {
  records: readonly ShelfRow[];
  /** Number of the record and agent that is shown. */
  shown: number;
  program: ProgramContents | null;
  tasks: Tasks | null;
  holdings: Holdings | null;
  monitors: Monitors | null;
  signals: Signals | null;
  /** Newest values by name of the signal, with units. */
  values: ReadonlyMap<string, string>;
  names: Names;
  atNs: number;
}

type Node = TreeNode<Thing>;

/** Signs of conditions that hold, that do not, and that the data do not decide. */
const GLYPHS: Record<string, string> = { true: '●', false: '○', null: '◌' };

export function objectTree(things: Things): Node[] {
  return [
    group('agents', agents(things), things.records.length > 0),
    group('procedures', procedures(things), things.program !== null),
    group('resources', resources(things), things.program !== null && things.holdings !== null),
    group('monitors', monitors(things), things.monitors !== null),
    group('variables', variables(things), things.signals !== null),
  ];
}

/** A group with the number of its objects; while they are not known, it has no number. */
function group(id: string, children: Node[], known: boolean): Node {
  const leaves = children.reduce((sum, child) => sum + Math.max(child.children.length, 1), 0);
  return {
    id,
    words: id,
    note: known ? String(leaves) : 'not read',
    open: id === 'agents' || id === 'resources',
    children,
  };
}

function agents({ records, shown }: Things): Node[] {
  return records.map(row => ({
    id: `record ${row.id}`,
    words: row.agent,
    glyph: row.id === shown ? '●' : '○',
    note: row.fork ? `fork: ${row.fork.with}` : row.record,
    title: row.id === shown ? 'shown' : 'show this agent',
    choosable: row.id !== shown,
    chosen: row.id === shown,
    data: { kind: 'record', id: row.id },
    children: [],
  }));
}

/** Procedures by file, with the number of living tasks that carry each out. */
function procedures({ program, tasks, names }: Things): Node[] {
  const used = new Map<string, number>();
  for (const task of tasks?.tasks ?? []) {
    const place = task.method_place;
    if (place && task.state !== 'terminated') used.set(place, (used.get(place) ?? 0) + 1);
  }
  const files = new Map<string, ProcedureRow[]>();
  for (const row of program?.procedures ?? []) {
    const file = fileOf(row.place);
    files.set(file, [...(files.get(file) ?? []), row]);
  }
  return [...files].map(([file, rows]) => ({
    id: `file ${file}`,
    words: file,
    note: String(rows.length),
    children: rows.map(row => {
      const count = used.get(row.place) ?? 0;
      return {
        id: `${row.kind} ${row.place}`,
        words: phrase(row.index, names),
        glyph: count > 0 ? '●' : '○',
        note: [row.kind === 'procedure' ? '' : row.kind, count > 0 ? `${count} at work` : '']
          .filter(Boolean)
          .join(' · '),
        title: `${row.index}\n${row.place}`,
        choosable: true,
        data: { kind: 'place' as const, place: row.place },
        children: [],
      };
    }),
  }));
}

/** Resources that are declared or were held, with their holders. */
function resources({ program, holdings, tasks, names, atNs }: Things): Node[] {
  const declared = new Map((program?.resources ?? []).map(one => [one.name, one]));
  const rows = holdings?.resources ?? [];
  const goal = (task: number) => {
    const found = tasks?.tasks.find(one => one.id === task);
    return found ? phrase(found.goal, names) : `T${task}`;
  };
  const all = new Set([...rows.map(row => row.resource), ...declared.keys()]);
  return [...all].map(name => {
    const held = rows.find(row => row.resource === name)?.holdings ?? [];
    // A child task shares its parent's resource, so the last holder is the one that uses it.
    const holder = held.findLast(one => one.from_ns <= atNs && (one.open || one.to_ns > atNs));
    const note = holder ? `${goal(holder.task)} since ${missionTime(holder.from_ns).slice(2)}` : 'free';
    return {
      id: `resource ${name}`,
      words: name,
      glyph: holder ? '●' : '○',
      note: [declared.get(name)?.detail ?? '', note].filter(Boolean).join(' · '),
      choosable: holder !== undefined,
      data: holder && { kind: 'task' as const, task: holder.task },
      children: [],
    };
  });
}

function monitors({ monitors, names }: Things): Node[] {
  return (monitors?.monitors ?? []).map((one, index) => ({
    id: `monitor ${one.task} ${index}`,
    words: `${phrase(one.goal, names)} · ${one.clause}`,
    glyph: GLYPHS[String(holdsOf(one.condition))],
    note: `T${one.task}`,
    title: one.condition.text,
    choosable: true,
    data: { kind: 'task' as const, task: one.task },
    children: [],
  }));
}

function variables({ signals, values }: Things): Node[] {
  const groups = new Map<string, Node[]>();
  for (const signal of signals?.signals ?? []) {
    const node: Node = {
      id: `signal ${signal.name}`,
      words: signal.attribute.replaceAll('-', ' '),
      value: values.get(signal.name),
      note: signal.limits.some(limit => limit.guarded) ? 'watched' : undefined,
      title: signal.name,
      choosable: signal.kind !== 'other',
      data: { kind: 'signal', name: signal.name },
      children: [],
    };
    groups.set(signal.object, [...(groups.get(signal.object) ?? []), node]);
  }
  return [...groups].map(([object, children]) => ({
    id: `object ${object}`,
    words: object || 'no object',
    note: String(children.length),
    children,
  }));
}

export function fileOf(place: string): string {
  return place.replace(/:\d+:\d+$/, '');
}
