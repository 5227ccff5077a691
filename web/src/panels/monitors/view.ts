/** View model of the monitors: a tree of conditions with value, limit and the instant of the last change. Pure. */

import type { TreeNode } from '../../parts/rows';
import { holdsOf } from '../../record/conditions';
import type { MonitoredCondition, Monitors, TaskMonitor } from '../../record/types';
import { missionTime } from '../../time/format';
import { shortValue, withDurations } from '../../words/duration';
import { brief, type Names, phrase } from '../../words/phrase';

export interface MonitorData {
  task: number;
  variable: string | null;
  place: string;
}

/** Kinds of conditions that combine others, as text. */
const COMBINED: Record<string, string> = {
  and: 'all of',
  or: 'one of',
  'in-order': 'in this order',
  not: 'not',
  absent: 'absent',
};

/** Returns ● if a condition holds, ○ if it does not, ◌ if it is unknown. */
export function glyphOf(holds: boolean | null): string {
  return holds === null ? '◌' : holds ? '●' : '○';
}

/** Returns one branch for each watched clause; clauses that watch measured values come first. */
export function monitorTree(
  monitors: Monitors | null,
  names: Names,
  selected: number | null,
  find = '',
): TreeNode<MonitorData>[] {
  const wanted = find.trim().toLowerCase();
  const fits = (one: TaskMonitor) =>
    wanted === '' || `${one.goal} ${one.clause} ${one.condition.text}`.toLowerCase().includes(wanted);
  const rows = (monitors?.monitors ?? []).filter(fits);
  const measured = (one: MonitoredCondition): boolean => one.variable !== null || one.parts.some(measured);
  const sorted = [...rows].sort((a, b) => Number(measured(b.condition)) - Number(measured(a.condition)));
  return sorted.map((one, index) => {
    const data = { task: one.task, variable: null, place: one.condition.place };
    const id = `${one.task}.${one.clause}.${index}`;
    return {
      id,
      words: `${phrase(one.goal, names)} · ${one.clause}`,
      glyph: glyphOf(holdsOf(one.condition)),
      note: `T${one.task}`,
      title: `${one.goal}\n${one.condition.text}`,
      chosen: one.task === selected,
      choosable: true,
      open: measured(one.condition) || one.task === selected,
      data,
      children: [conditionNode(one.condition, `${id}.0`, one.task, names)],
    };
  });
}

function conditionNode(
  one: MonitoredCondition,
  id: string,
  task: number,
  names: Names,
): TreeNode<MonitorData> {
  const children = one.parts.map((part, index) => conditionNode(part, `${id}.${index}`, task, names));
  const since =
    one.since_ns === null ? '' : `${one.holds ? 'since' : 'as of'} ${missionTime(one.since_ns).slice(2)}`;
  const until = one.until_ns === null ? '' : `true at ${missionTime(one.until_ns).slice(2)} if it continues`;
  return {
    id,
    words: conditionWords(one, names),
    glyph: glyphOf(holdsOf(one)),
    value: one.value === null ? undefined : shortValue(one.value),
    note: [limitWords(one), since, until].filter(Boolean).join(' · ') || undefined,
    title: [one.text, withDurations(one.now), one.place].filter(Boolean).join('\n'),
    choosable: children.length === 0,
    open: true,
    data: { task, variable: one.variable, place: one.place },
    children,
  };
}

function conditionWords(one: MonitoredCondition, names: Names): string {
  if (one.variable !== null) return phrase(one.variable, names);
  const combined = COMBINED[one.kind];
  if (combined) return combined;
  if (one.parts.length > 0) return one.kind;
  return withDurations(brief(one.text, names));
}

/** Returns the limit of a condition as text: `limit > 15deg for 5 s`. */
export function limitWords(one: MonitoredCondition): string {
  if (one.limits.length === 0) return '';
  return `limit ${one.limits.map(limit => withDurations(shortValue(limit))).join(' ')}`;
}
