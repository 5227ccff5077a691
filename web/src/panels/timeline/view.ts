/** The timeline's geometry: times to pixels, lanes to rows, samples to strips; pure. */

import type { Range } from '../../player/clock';
import type { Alarm } from '../../record/alarms';
import { type Bar, type DenseBand, unpackBands, unpackRows } from '../../record/bands';
import { failures } from '../../record/failures';
import { columnUntil } from '../../record/measured';
import type { TaskState, Timeline, Track, Trouble } from '../../record/types';
import { NANOSECONDS_PER_SECOND, span } from '../../time/format';
import { type Names, phrase } from '../../words/phrase';
import { subjectWords } from '../../words/subject';

export { type Visit, visitsOf } from '../../record/visits';

/** Width of the column of names, in pixels. */
export const NAMES_PX = 168;
/** Height of the time axis. */
export const AXIS_PX = 20;
/** Height of a row of bars. */
export const ROW_PX = 15;
/** Height of the rail of failures and faults above the time axis. */
export const RAIL_PX = 16;
/** Height of the lane of target visits. */
export const VISITS_PX = 18;
/** Height of a strip chart. */
export const STRIP_PX = 27;
/** Height of a row of a target. */
export const TARGET_PX = 12;
/** Greatest share of the timeline's height for rows of targets, while other rows are shown, too. */
const TARGETS_SHARE = 0.52;

/** The height of the rows of targets above strips and lanes. */
export function targetsHeight(targets: number, height: number): number {
  return Math.min(targets * TARGET_PX, Math.floor(height * TARGETS_SHARE));
}

/** From mission time to pixels of the drawing, and back. */
export interface Scale {
  x(atNs: number): number;
  at(x: number): number;
}

export function scaleOf(visible: Range, width: number): Scale {
  const span = Math.max(visible.toNs - visible.fromNs, 1);
  const room = Math.max(width - NAMES_PX, 1);
  return {
    x: atNs => NAMES_PX + ((atNs - visible.fromNs) / span) * room,
    at: x => visible.fromNs + ((x - NAMES_PX) / room) * span,
  };
}

/** The values of the time cursor in whole seconds. They end with the axis, because the end of the flight is not known before it. */
export function cursorValues(axis: Range, atNs: number): { min: number; max: number; now: number } {
  const seconds = (ns: number) => Math.floor(ns / NANOSECONDS_PER_SECOND);
  return { min: seconds(axis.fromNs), max: seconds(axis.toNs), now: seconds(atNs) };
}

export interface LaneRow {
  y: number;
  height: number;
  name: string;
  depth: number;
  /** Number of tasks in the lane; shown if more than one. */
  tasks: number;
  rows: Bar[][];
  /** Intervals too dense for bars. If the lane also has bars, they are in the row below them. */
  bands: DenseBand[];
}

/** Lanes below each other; the height of a lane follows from its rows. Lanes beyond the limit are merged into the last one. */
export function layLanes(
  timeline: Timeline | null,
  names: Names = new Map(),
): { lanes: LaneRow[]; height: number } {
  let y = 0;
  const place = (name: string, depth: number, tasks: number, rows: Bar[][], bands: DenseBand[]): LaneRow => {
    // Dense stretches lie in the first row unless that has bars.
    const height = Math.max(rows.length + (bandsApart({ rows, bands }) ? 1 : 0), 1) * ROW_PX;
    const row = { y, height, name, depth, tasks, rows, bands };
    y += height;
    return row;
  };
  if (!timeline) return { lanes: [], height: 0 };
  const lanes = timeline.lanes.map(lane =>
    place(
      laneName(lane, names),
      lane.depth,
      lane.tasks,
      unpackRows(lane.rows),
      unpackBands(lane.bands, timeline),
    ),
  );
  const more = timeline.more;
  if (more.lanes > 0) {
    const name = `${more.lanes} more ${more.lanes === 1 ? 'lane' : 'lanes'}`;
    lanes.push(place(name, 0, more.tasks, [], unpackBands(more.bands, timeline)));
  }
  return { lanes, height: y };
}

/** True if a lane's bands need a row below its bars, because they would cover the bars. */
export function bandsApart(lane: { rows: Bar[][]; bands: DenseBand[] }): boolean {
  return lane.rows.length > 0 && lane.bands.length > 0;
}

export interface DenseBlock {
  x: number;
  width: number;
  /** Share of the time with work, 0 to 1. */
  share: number;
}

/** A stretch of neighbouring bands: its blocks and its number of intervals. */
export interface DenseRun {
  x: number;
  width: number;
  count: number;
  blocks: DenseBlock[];
}

/** Bands as blocks of at least a pixel, up to `atNs`; neighbours less than three pixels apart form one run. */
export function densityOf(
  bands: readonly DenseBand[],
  visible: Range,
  atNs: number,
  scale: Scale,
): DenseRun[] {
  const runs: DenseRun[] = [];
  for (const band of bands) {
    const toNs = Math.min(band.to_ns, visible.toNs, atNs);
    if (toNs < visible.fromNs || band.from_ns > Math.min(visible.toNs, atNs)) continue;
    const x = Math.max(scale.x(band.from_ns), NAMES_PX);
    const width = Math.max(scale.x(toNs) - x, 1);
    const last = runs.at(-1);
    const run = last && x - (last.x + last.width) < 3 ? last : { x, width: 0, count: 0, blocks: [] };
    if (run !== last) runs.push(run);
    run.width = Math.max(run.width, x + width - run.x);
    run.count += band.count;
    run.blocks.push({ x, width, share: band.ongoing });
  }
  return runs;
}

/** An alarm of a signal, as an entry of the rail; its subject is its words. */
export type SignalTrouble = Pick<Trouble, 't_ns' | 'subject' | 'cause' | 'task' | 'target'> & {
  kind: 'signal';
};
export type RailEntry = Trouble | SignalTrouble;

export interface TroubleMark {
  x: number;
  troubles: RailEntry[];
}

/** The entries of the rail up to an instant, oldest first: failures, faults and the alarms of signals. */
export function railEntries(
  troubles: readonly Trouble[],
  alarms: readonly Alarm[],
  atNs: number,
): RailEntry[] {
  const signals = alarms.flatMap((alarm): SignalTrouble[] =>
    alarm.signal === null
      ? []
      : [
          {
            t_ns: alarm.firstNs,
            kind: 'signal',
            subject: alarm.words,
            cause: alarm.cause,
            task: null,
            target: null,
          },
        ],
  );
  const failed = failures(troubles.filter(trouble => trouble.t_ns <= atNs));
  return [...failed, ...signals].sort((a, b) => a.t_ns - b.t_ns);
}

/** Failures and faults of the window as marks; those less than six pixels apart are one mark with a count. */
export function troubleMarks(troubles: readonly RailEntry[], visible: Range, scale: Scale): TroubleMark[] {
  const marks: TroubleMark[] = [];
  for (const trouble of troubles) {
    if (trouble.t_ns < visible.fromNs || trouble.t_ns > visible.toNs) continue;
    const x = scale.x(trouble.t_ns);
    const last = marks.at(-1);
    if (last && x - last.x < 6) last.troubles.push(trouble);
    else marks.push({ x, troubles: [trouble] });
  }
  return marks;
}

const TROUBLE_WORDS: Record<RailEntry['kind'], (subject: string) => string> = {
  failed: subject => `failed: ${subject}`,
  interrupted: subject => `interrupted: ${subject}`,
  fault: subject => `fault: ${subject}`,
  'left-out': subject => `left out: ${subject}`,
  ended: subject => `failed: ${subject}`,
  signal: subject => subject,
};

/** `interrupted: scan Columbine`: a goal as a phrase, a target by its name. */
export function troubleWords(trouble: RailEntry, names: Names): string {
  return TROUBLE_WORDS[trouble.kind](subjectWords(trouble.subject, names));
}

/** A lane with a single task is named by the task's goal; a lane with many tasks of one step by their common goal head. */
function laneName(lane: { tag: string; goal: string; tasks: number }, names: Names): string {
  const goal = lane.goal.replace(/^\((.*)\)$/s, '$1');
  if (lane.tasks === 1) return phrase(lane.goal, names);
  return (goal.split(/\s/)[0] ?? lane.tag).replaceAll('-', ' ');
}

/** The bar at a point of the lanes (`y` from the top of the first lane). */
export function barAt(lanes: readonly LaneRow[], x: number, y: number, scale: Scale): Bar | null {
  const lane = lanes.find(candidate => y >= candidate.y && y < candidate.y + candidate.height);
  const row = lane?.rows[Math.floor((y - lane.y) / ROW_PX)];
  if (!row) return null;
  // Bars thinner than three pixels can be hit too.
  const slack = 1.5;
  return row.findLast(bar => scale.x(bar.from_ns) - slack <= x && x <= scale.x(bar.to_ns) + slack) ?? null;
}

/** The lane that a task's bars are in. */
export function laneOf(lanes: readonly LaneRow[], task: number): LaneRow | undefined {
  return lanes.find(lane => lane.rows.some(row => row.some(bar => bar.task === task)));
}

/** The deepest lane with an ongoing task at an instant; among several, the one whose task began last. */
export function laneAtWork(lanes: readonly LaneRow[], atNs: number): LaneRow | undefined {
  let best: { lane: LaneRow; since: number } | undefined;
  for (const lane of lanes) {
    for (const bar of lane.rows.flat()) {
      if (bar.state !== 'ongoing' || bar.from_ns > atNs || bar.to_ns < atNs) continue;
      const better =
        !best || lane.depth > best.lane.depth || (lane.depth === best.lane.depth && bar.from_ns > best.since);
      if (better) best = { lane, since: bar.from_ns };
    }
  }
  return best?.lane;
}

/** The scroll position at which a lane is visible: the present one if it is, otherwise with a row's height beyond the lane. */
export function scrollTo(lane: LaneRow, scrollPx: number, room: number): number {
  if (lane.y >= scrollPx && lane.y + lane.height <= scrollPx + room) return scrollPx;
  return Math.max(0, lane.y < scrollPx ? lane.y - ROW_PX : lane.y + lane.height + ROW_PX - room);
}

export interface Block {
  x: number;
  width: number;
  state: TaskState;
  task: number;
}

/** A row's bars up to `atNs` as blocks to fill. Adjacent bars narrower than a pixel are one block, so that a million bars take little
 * more time to draw than a thousand. */
export function blocksOf(row: readonly Bar[], visible: Range, atNs: number, scale: Scale): Block[] {
  const blocks: Block[] = [];
  const endNs = Math.min(visible.toNs, atNs);
  for (const bar of row) {
    if (bar.to_ns < visible.fromNs || bar.from_ns > endNs) continue;
    const x = Math.max(scale.x(bar.from_ns), NAMES_PX);
    const width = Math.max(scale.x(Math.min(bar.to_ns, endNs)) - x, 1);
    const last = blocks.at(-1);
    if (last && width <= 1 && last.state === bar.state && x - (last.x + last.width) < 1) {
      last.width = Math.max(last.width, x + width - last.x);
    } else {
      blocks.push({ x, width, state: bar.state, task: bar.task });
    }
  }
  return blocks;
}

export interface Strip {
  name: string;
  unit: string;
  low: number;
  high: number;
  /** Fraction digits of its numbers. */
  decimals: number;
  times: number[];
  values: number[];
}

/** The quantities drawn as strips, in this order, if the record has them, with their samples up to `atNs`. `tail` has all samples of the
 * last time, so that the last one is the present value. */
export function stripsOf(track: Track | null, tail: Track | null, atNs: number): Strip[] {
  if (!track) return [];
  return [
    strip('altitude', 'm', track, tail, 'altitude_m', atNs, 0),
    strip('roll', '°', track, tail, 'roll_deg', atNs, 1),
    strip('fuel', 'kg', track, tail, 'fuel_kg', atNs, 0),
  ].filter(made => made !== null);
}

function strip(
  name: string,
  unit: string,
  track: Track,
  tail: Track | null,
  column: 'altitude_m' | 'roll_deg' | 'fuel_kg',
  atNs: number,
  decimals: number,
): Strip | null {
  // The row is present from the start, and only its samples depend on the time.
  if (track[column].every(value => value === null)) return null;
  const { times, values } = columnUntil(track, tail, column, atNs);
  let [low, high] = [Number.POSITIVE_INFINITY, Number.NEGATIVE_INFINITY];
  for (const value of values) [low, high] = [Math.min(low, value), Math.max(high, value)];
  return { name, unit, low, high, decimals, times, values };
}

/** Age from which a value is shown with it: the duration of `tail`. */
const OLD_NS = 60 * NANOSECONDS_PER_SECOND;

/** `69 m`, the last value of a strip up to `atNs`; with its age if it is old: `69 m, 3 min 20 s ago`. */
export function valueWords(strip: Strip, atNs: number): string {
  const [time, value] = [strip.times.at(-1), strip.values.at(-1)];
  if (time === undefined || value === undefined) return '';
  const ageNs = atNs - time;
  return `${value.toFixed(strip.decimals)} ${strip.unit}${ageNs > OLD_NS ? `, ${span(ageNs)} ago` : ''}`;
}

/** Points of a strip's line: at most one lowest and one highest value for each pixel. */
export function lineOf(
  strip: Strip,
  visible: Range,
  scale: Scale,
  top: number,
  height: number,
): [number, number][] {
  const range = strip.high - strip.low;
  const y = (value: number) => top + height - (range > 0 ? (value - strip.low) / range : 0.5) * height;
  const points: [number, number][] = [];
  let column = Number.NaN;
  strip.times.forEach((time, index) => {
    const before = strip.times[index - 1] ?? time;
    const after = strip.times[index + 1] ?? time;
    if (after < visible.fromNs || before > visible.toNs) return;
    const x = scale.x(time);
    const height = y(strip.values[index] as number);
    const last = points.at(-1);
    const previous = points.at(-2);
    if (Math.floor(x) === column && last && previous && Math.floor(previous[0]) === column) {
      // Further points of a pixel only widen the range between its two points.
      const [upper, lower] = previous[1] < last[1] ? [previous, last] : [last, previous];
      upper[1] = Math.min(upper[1], height);
      lower[1] = Math.max(lower[1], height);
    } else {
      column = Math.floor(x);
      points.push([x, height]);
    }
  });
  return points;
}
