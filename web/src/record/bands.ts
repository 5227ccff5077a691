// Bands and bars of the timeline: sent in a short form, drawn as stretches of time.

import type { Band, TaskState, Timeline } from './types';

/** A span of time that a task spent in one state. */
export interface Bar {
  task: number;
  state: TaskState;
  from_ns: number;
  to_ns: number;
}

/** The states by their numbers in a run of bars. */
const STATES: readonly TaskState[] = ['pending', 'enabled', 'ongoing', 'interrupted'];

/** A stretch of time with more intervals than can be drawn. */
export interface DenseBand {
  from_ns: number;
  to_ns: number;
  /** Intervals that begin here. */
  count: number;
  /** Share of the time with an ongoing task, 0 to 1. */
  ongoing: number;
}

type Window = Pick<Timeline, 'from_ns' | 'to_ns' | 'at_ns' | 'pixel_ns'>;

/** The bands of a lane in this timeline; the last band ends at the last known time of the flight. */
export function unpackBands(bands: readonly Band[], window: Window): DenseBand[] {
  const known = Math.min(window.to_ns, window.at_ns);
  return bands.map(([pixel, pixels, count, thousandths]) => {
    const from_ns = window.from_ns + pixel * window.pixel_ns;
    const to_ns = Math.max(Math.min(from_ns + pixels * window.pixel_ns, known), from_ns);
    return { from_ns, to_ns, count, ongoing: thousandths / 1000 };
  });
}

/** The bars of a lane, row by row: each run is a task, a time, and then a state and a length for each bar without a gap. */
export function unpackRows(rows: readonly number[][][]): Bar[][] {
  return rows.map(runs => {
    const bars: Bar[] = [];
    for (const [task = 0, begin = 0, ...spans] of runs) {
      let from_ns = begin;
      for (let at = 0; at + 1 < spans.length; at += 2) {
        const [code, length] = [spans[at] ?? 0, spans[at + 1] ?? 0];
        const to_ns = from_ns + length;
        bars.push({ task, state: STATES[code] ?? 'pending', from_ns, to_ns });
        from_ns = to_ns;
      }
    }
    return bars;
  });
}
