/** Two records on one time axis; pure. */

import type { Mission, Target } from '../../record/types';
import { type Visit, visitsOf } from '../../record/visits';
import { clock } from '../../time/format';

export interface Bar {
  fromNs: number;
  toNs: number;
  state: string;
}

export interface CompareRow {
  id: string;
  name: string;
  states: [string, string];
  bars: [Bar[], Bar[]];
  /** True if the two flights differ for this target so far. */
  differs: boolean;
  words: string;
}

/** Visits whose begins differ by less count as the same. */
const SAME_NS = 1e9;

/** One row for each target known to either flight; targets that differ come first. */
export function compareRows(first: readonly Target[], second: readonly Target[], atNs: number): CompareRow[] {
  const ids = [...new Set([...first, ...second].map(target => target.id))];
  const visits = [visitsOf(first, atNs), visitsOf(second, atNs)] as const;
  const rows = ids.map(id => {
    const pair = [first.find(one => one.id === id), second.find(one => one.id === id)] as const;
    const bars = visits.map(list => barsOf(list, id)) as [Bar[], Bar[]];
    const states = pair.map(one => (one ? (one.state ?? 'known') : 'not known')) as [string, string];
    const begins = bars.map(list => list[0]?.fromNs ?? null);
    const moved =
      begins[0] === null || begins[1] === null
        ? begins[0] !== begins[1]
        : Math.abs((begins[0] ?? 0) - (begins[1] ?? 0)) >= SAME_NS;
    const words = states.map((state, index) => {
      const begin = begins[index];
      return begin === null || begin === undefined ? state : `${state} ${clock(begin / 1e9)}`;
    });
    return {
      id,
      name: pair[0]?.name ?? pair[1]?.name ?? id,
      states,
      bars,
      differs: states[0] !== states[1] || moved,
      words: words.join(', '),
    };
  });
  return rows.sort((a, b) => Number(b.differs) - Number(a.differs));
}

function barsOf(visits: readonly Visit[], id: string): Bar[] {
  return visits.filter(visit => visit.id === id).map(({ fromNs, toNs, state }) => ({ fromNs, toNs, state }));
}

/** Figures of both flights at the instant. */
export function figures(
  first: Mission | null,
  second: Mission | null,
): { name: string; values: [string, string] }[] {
  const both = (
    name: string,
    of: (mission: Mission) => string,
  ): { name: string; values: [string, string] } => ({
    name,
    values: [first ? of(first) : '–', second ? of(second) : '–'],
  });
  return [
    both('observed', one => `${one.observed} of ${one.targets}`),
    both('tasks', one => String(one.tasks)),
    both('score', one => (one.score === null ? 'not yet' : one.score.toFixed(1))),
    both('end', one => one.ending?.reason ?? 'under way'),
  ];
}
