/** Contents of the signals panel: the shown signals, their columns for drawing, limits and excursions as text; pure. */

import type { Range } from '../../player/clock';
import type { Excursion, Signal, SignalLimit, SignalWindow } from '../../record/types';
import { missionTime, NANOSECONDS_PER_SECOND, span } from '../../time/format';
import { type ShownUnit, shownUnit, withUnit } from '../../units/aviation';

/** Signals without a limit that are shown at first, if the record has them. */
const FIRST = ['altitude', 'ground-speed', 'fuel', 'battery-charge'];
/** Number of signals shown at first. */
const FIRST_COUNT = 4;

/** Words such as `roll angle`, with the object if another signal has the same attribute. */
export function signalWords(signal: Signal, all: readonly Signal[]): string {
  const attribute = signal.attribute.replaceAll('-', ' ');
  const alone = all.filter(other => other.attribute === signal.attribute).length < 2;
  return alone ? attribute : `${attribute} of ${signal.object.replaceAll('-', ' ')}`;
}

/** The name of a signal in the address: without parentheses, `roll-angle aircraft-1`. */
export function addressName(signal: Signal): string {
  return signal.name.replace(/^\(|\)$/g, '');
}

/** The signals in the address; without any, first those that the mission guards, then some that every flight has. */
export function chosenSignals(all: readonly Signal[], asked: readonly string[] | null): Signal[] {
  if (asked) return [...new Set(asked.flatMap(name => namedSignal(all, name) ?? []))];
  const guarded = all.filter(signal => signal.limits.some(limit => limit.guarded));
  const usual = FIRST.flatMap(name => all.find(signal => signal.attribute === name) ?? []);
  return [...new Set([...guarded, ...usual])].slice(0, FIRST_COUNT);
}

/** The signal of a name in the address; an attribute without its object names the only signal that has it. */
function namedSignal(all: readonly Signal[], name: string): Signal | undefined {
  const plotted = all.filter(signal => signal.kind !== 'other');
  const named = plotted.filter(signal => signal.attribute === name);
  return plotted.find(signal => addressName(signal) === name) ?? (named.length === 1 ? named[0] : undefined);
}

/** What is wrong with the names in the address at an instant: signals that are not measured by then, or attributes of several objects. */
export function signalFaults(all: readonly Signal[], asked: readonly string[] | null): string[] {
  return (asked ?? [])
    .filter(name => !namedSignal(all, name))
    .map(name => {
      const objects = all.filter(signal => signal.attribute === name).map(addressName);
      return objects.length > 0
        ? `${name} is measured of several objects: ${objects.join(', ')}.`
        : `No signal ${name} was measured by this time; the field above lists those that were.`;
    });
}

export function unitOf(signal: Signal): ShownUnit {
  return shownUnit(`${signal.attribute} ${signal.object}`, signal.unit);
}

/** Columns for the plot: seconds of mission time, then lowest, highest and mean values in the shown unit. */
export type Columns = [number[], number[], number[], number[]];

export function columnsOf(window: SignalWindow, atNs: number): Columns {
  const { factor } = unitOf(window);
  const scaled = (values: readonly number[]) => values.map(value => value * factor);
  const columns: Columns = [
    window.t_ns.map(time => time / NANOSECONDS_PER_SECOND),
    scaled(window.low),
    scaled(window.high),
    scaled(window.mean),
  ];
  const last = window.t_ns.at(-1);
  // A value that is a word holds until the next sample.
  if (window.kind === 'words' && last !== undefined && last < atNs) {
    const word = window.mean.at(-1) ?? 0;
    columns[0].push(atNs / NANOSECONDS_PER_SECOND);
    for (const column of columns.slice(1)) column.push(word);
  }
  return columns;
}

/** The range of the value axis: all values, limits that are near enough to them, and a margin. */
export function valueRange(window: SignalWindow): [number, number] {
  if (window.kind === 'words') return [-0.5, Math.max(window.words.length - 0.5, 0.5)];
  const { factor } = unitOf(window);
  let low = Math.min(...window.low);
  let high = Math.max(...window.high);
  if (!Number.isFinite(low)) return [0, 1];
  const reach = high - low;
  for (const limit of window.limits) {
    for (const bound of [limit.low, limit.high]) {
      if (bound === null || bound < low - reach || bound > high + reach) continue;
      low = Math.min(low, bound);
      high = Math.max(high, bound);
    }
  }
  const room = Math.max((high - low) * 0.08, Math.abs(high) * 0.01, 1e-6);
  return [(low - room) * factor, (high + room) * factor];
}

/** `±3.00° for 5.0 s`, `below 0.200 for 20 s`. */
export function limitWords(limit: SignalLimit, signal: Signal): string {
  const { unit, factor } = unitOf(signal);
  const { low, high } = limit;
  const both = low !== null && high !== null;
  const text = both
    ? low === -high
      ? `beyond ±${withUnit(high * factor, unit)}`
      : `outside ${withUnit(low * factor, unit)} to ${withUnit(high * factor, unit)}`
    : low !== null
      ? `below ${withUnit(low * factor, unit)}`
      : `above ${withUnit((high ?? 0) * factor, unit)}`;
  return limit.duration_s === null ? text : `${text} for ${span(limit.duration_s * NANOSECONDS_PER_SECOND)}`;
}

export interface ExcursionView {
  atNs: number;
  text: string;
  raised: boolean;
}

/** Excursions of guarded limits as text: those to which the mission responded, and the number of others. */
export function excursionsOf(window: SignalWindow): { answered: ExcursionView[]; others: number } {
  const { unit, factor } = unitOf(window);
  const guarded = window.excursions.filter(one => window.limits[one.limit]?.guarded);
  const answered = guarded.filter(one => one.raised_ns !== null);
  const view = (one: Excursion): ExcursionView => ({
    atNs: one.from_ns,
    text: `${missionTime(one.from_ns)}, ${span(one.to_ns - one.from_ns)}, up to ${withUnit(one.peak * factor, unit)}`,
    raised: true,
  });
  return { answered: answered.map(view), others: guarded.length - answered.length + window.left_out };
}

/** The entry of the plot at `index` as text: time, value, and the extremes of the pixel if there are several samples. */
export function pointWords(window: SignalWindow, index: number): string {
  const time = window.t_ns[index] ?? window.t_ns.at(-1);
  const mean = window.mean[Math.min(index, window.mean.length - 1)];
  if (time === undefined || mean === undefined) return '';
  if (window.kind === 'words') return `${missionTime(time)} ${window.words[mean] ?? ''}`;
  const { unit, factor } = unitOf(window);
  const count = window.count[index] ?? 1;
  const value = `${missionTime(time, 1)} ${withUnit(mean * factor, unit)}`;
  if (count < 2) return value;
  const [low, high] = [window.low[index] ?? mean, window.high[index] ?? mean];
  return `${value}, ${withUnit(low * factor, unit)} to ${withUnit(high * factor, unit)} of ${count} samples`;
}

/** The last known value as text; in a unit of aviation also in that of the record, in which other panels show it. */
export function valueNow(window: SignalWindow): string {
  const last = window.mean.at(-1);
  if (last === undefined) return '';
  if (window.kind === 'words') return window.words[last] ?? '';
  const { unit, factor } = unitOf(window);
  const value = window.statistics?.last ?? last;
  const shown = withUnit(value * factor, unit);
  return factor === 1 ? shown : `${shown} (${withUnit(value, window.unit)})`;
}

/** Statistics as pairs, over the range that the request states. */
export function statisticsOf(window: SignalWindow): { name: string; value: string }[] {
  const { statistics } = window;
  if (!statistics) return [{ name: 'samples', value: String(window.samples) }];
  const { unit, factor } = unitOf(window);
  const shown = (value: number) => withUnit(value * factor, unit);
  return [
    { name: 'lowest', value: shown(statistics.low) },
    { name: 'highest', value: shown(statistics.high) },
    { name: 'mean', value: shown(statistics.mean) },
    { name: 'deviation', value: shown(statistics.deviation) },
    { name: 'samples', value: String(statistics.samples) },
  ];
}

/** `9:00:00 to 9:20:00`: a range as text. */
export function rangeWords(range: Range): string {
  return `${missionTime(range.fromNs).slice(2)} to ${missionTime(range.toNs).slice(2)}`;
}

/** The samples of windows as columns, in the record's unit: one row for each sample, or for each pixel if there are more samples. */
export function samplesTable(windows: readonly SignalWindow[]) {
  const table = {
    signal: [] as string[],
    unit: [] as string[],
    time_s: [] as number[],
    /** A number; null for a word. */
    value: [] as (number | null)[],
    lowest: [] as (number | null)[],
    highest: [] as (number | null)[],
    word: [] as string[],
    samples: [] as number[],
  };
  for (const window of windows) {
    const isWord = window.kind === 'words';
    window.t_ns.forEach((time, index) => {
      const mean = window.mean[index] ?? Number.NaN;
      table.signal.push(window.name);
      table.unit.push(window.unit);
      table.time_s.push(time / NANOSECONDS_PER_SECOND);
      table.value.push(isWord ? null : mean);
      table.lowest.push(isWord ? null : (window.low[index] ?? null));
      table.highest.push(isWord ? null : (window.high[index] ?? null));
      table.word.push(isWord ? (window.words[mean] ?? '') : '');
      table.samples.push(window.count[index] ?? 1);
    });
  }
  return table;
}

/** The samples of windows as rows for comma-separated values. */
export function samplesRows(windows: readonly SignalWindow[]): (string | number | null)[][] {
  const table = samplesTable(windows);
  const rows = table.signal.map((signal, index) => [
    signal,
    table.unit[index] ?? '',
    table.time_s[index] ?? null,
    table.value[index] ?? table.word[index] ?? null,
    table.lowest[index] ?? null,
    table.highest[index] ?? null,
    table.samples[index] ?? null,
  ]);
  return [['signal', 'unit', 'time_s', 'value', 'lowest', 'highest', 'samples'], ...rows];
}
