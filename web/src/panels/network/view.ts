/** A procedure, or a plan, as a network of activities (PERT): layers, edges, times, the longest path; pure. */

import type { PlanInForce, ProcedureRow, Target, Task } from '../../record/types';
import { begunVisits } from '../../record/visits';
import { clock, plannedClock } from '../../time/format';
import { type Names, phrase } from '../../words/phrase';
import { stateSign } from '../../words/state';

export interface Activity {
  id: string;
  words: string;
  /** ○ waits, ◇ ready, ● at work, ▨ interrupted, ✓ done, – cut, ▲ failed, · not begun. */
  glyph: string;
  /** The times, or the awaited conditions, in one line. */
  note: string;
  title: string;
  task: number | null;
  target: string | null;
  place: string | null;
  after: string[];
  /** Duration in seconds: as executed so far, or otherwise as planned; 0 if unknown. */
  seconds: number;
}

export interface NetworkNode extends Activity {
  x: number;
  y: number;
  /** True if the activity is on the longest path by duration. */
  critical: boolean;
}

export interface Network {
  nodes: NetworkNode[];
  /** Outlines of the arrows, as SVG paths. */
  edges: { path: string; critical: boolean }[];
  width: number;
  height: number;
}

export const NODE = { width: 148, height: 40, gapX: 34, gapY: 18 };

/** The steps of a procedure as activities, with the tasks that execute them for `parent`. */
export function procedureActivities(
  row: ProcedureRow,
  tasks: readonly Task[],
  parent: number | null,
  atNs: number,
  names: Names,
): Activity[] {
  const known = new Set(row.steps.map(step => step.tag));
  return row.steps.map(step => {
    const task = tasks.findLast(one => one.parent === parent && parent !== null && one.place === step.place);
    const begun = task && task.state !== 'pending';
    const until = task?.state === 'terminated' ? task.since_ns : atNs;
    const waits =
      step.waits.length > 0
        ? `waits for ${step.waits.length === 1 ? 'a condition' : `${step.waits.length} conditions`}`
        : '';
    const times = begun
      ? `${clock(task.created_ns / 1e9)}–${task.state === 'terminated' ? clock(until / 1e9) : ''}`
      : '';
    return {
      id: step.tag,
      words: phrase(task?.goal ?? step.activity, names),
      glyph: stateSign(task),
      note: [times || waits, step.repeats ? 'repeats' : '', step.ends ? 'ends it' : '']
        .filter(Boolean)
        .join(' · '),
      title: [step.tag, task?.goal ?? step.activity, ...step.waits, step.place].join('\n'),
      task: task?.id ?? null,
      target: null,
      place: step.place,
      after: step.after.filter(tag => known.has(tag) && tag !== step.tag),
      seconds: begun ? Math.max(0, until - task.created_ns) / 1e9 : 0,
    };
  });
}

/** States of a target that end a visit. */
const ENDS = new Set(['observed', 'skipped']);

/** The visits of a plan as activities in their order, planned next to flown. */
export function planActivities(plan: PlanInForce, targets: readonly Target[], atNs: number): Activity[] {
  const begun = begunVisits(plan, targets, atNs);
  return plan.visits.map((visit, index) => {
    const target = targets.find(one => one.id === visit.target || one.name === visit.target);
    const done = begun[index] ?? null;
    const end = target?.history.find(
      change => done !== null && change.t_ns > done && change.t_ns <= atNs && ENDS.has(change.state),
    );
    const glyph = done === null ? '○' : !end ? '●' : end.state === 'observed' ? '✓' : '–';
    const planned = `planned ${plannedClock(visit.begin_ns)}`;
    return {
      id: `${index} ${visit.target}`,
      words: target?.name ?? visit.target,
      glyph,
      note: done !== null ? `${planned}, flown ${clock(done / 1e9)}` : planned,
      title: `${visit.target}\n${planned} to ${plannedClock(visit.end_ns)}`,
      task: null,
      target: target?.id ?? null,
      place: null,
      after: index === 0 ? [] : [`${index - 1} ${plan.visits[index - 1]?.target}`],
      seconds: (visit.end_ns - visit.begin_ns) / 1e9,
    };
  });
}

/** Arranges the activities: each one is in the layer after the last activity for which it waits. A circle is cut at the edge that closes
 * it. */
export function layOut(activities: readonly Activity[], columns: number): Network {
  const byId = new Map(activities.map(one => [one.id, one]));
  const layers = new Map<string, number>();
  const lengths = new Map<string, number>();
  const visit = (id: string, open: Set<string>): number => {
    const found = layers.get(id);
    if (found !== undefined) return found;
    const one = byId.get(id);
    if (!one || open.has(id)) return -1;
    open.add(id);
    const before = one.after.map(each => visit(each, open));
    open.delete(id);
    const layer = Math.max(-1, ...before) + 1;
    layers.set(id, layer);
    lengths.set(id, one.seconds + Math.max(0, ...one.after.map(each => lengths.get(each) ?? 0)));
    return layer;
  };
  for (const one of activities) visit(one.id, new Set());
  const critical = longestPath(activities, lengths);
  const rows = new Map<number, number>();
  const chain =
    activities.every(one => one.after.length <= 1) && activities.length > columns && isChain(activities);
  const nodes = activities.map((one, index) => {
    const layer = layers.get(one.id) ?? 0;
    const row = rows.get(layer) ?? 0;
    rows.set(layer, row + 1);
    // A long chain runs in lines, like text.
    const [column, line] = chain ? [index % columns, Math.floor(index / columns)] : [layer, row];
    return {
      ...one,
      x: column * (NODE.width + NODE.gapX) + 6,
      y: line * (NODE.height + NODE.gapY) + 6,
      critical: critical.has(one.id),
    };
  });
  const at = new Map(nodes.map(node => [node.id, node]));
  const edges = nodes.flatMap(node =>
    node.after.flatMap(id => {
      const from = at.get(id);
      if (!from) return [];
      // Edges to the right connect the sides; other edges lead from the bottom to the top.
      const right = from.x < node.x;
      const [x0, y0] = right
        ? [from.x + NODE.width, from.y + NODE.height / 2]
        : [from.x + NODE.width / 2, from.y + NODE.height];
      const [x1, y1] = right ? [node.x, node.y + NODE.height / 2] : [node.x + NODE.width / 2, node.y];
      const [bendX, bendY] = right ? [NODE.gapX / 2, 0] : [0, NODE.gapY];
      const path = `M${x0} ${y0}C${x0 + bendX} ${y0 + bendY} ${x1 - bendX} ${y1 - bendY} ${x1} ${y1}`;
      return [{ path, critical: from.critical && node.critical }];
    }),
  );
  const width = Math.max(0, ...nodes.map(node => node.x)) + NODE.width + 6;
  const height = Math.max(0, ...nodes.map(node => node.y)) + NODE.height + 6;
  return { nodes, edges, width, height };
}

function isChain(activities: readonly Activity[]): boolean {
  return activities.every((one, index) => index === 0 || one.after[0] === activities[index - 1]?.id);
}

/** The activities on the longest path; none if no duration is known. */
function longestPath(activities: readonly Activity[], lengths: ReadonlyMap<string, number>): Set<string> {
  const path = new Set<string>();
  const longest = (ids: readonly string[]) =>
    ids.reduce<string | null>(
      (best, id) => ((lengths.get(id) ?? 0) > (lengths.get(best ?? '') ?? 0) ? id : best),
      null,
    );
  const byId = new Map(activities.map(one => [one.id, one]));
  for (
    let id = longest(activities.map(one => one.id));
    id && !path.has(id);
    id = longest(byId.get(id)?.after ?? [])
  ) {
    path.add(id);
  }
  return path;
}
