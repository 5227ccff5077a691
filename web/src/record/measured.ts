/** The vehicle's last measurements. The track of a record is thinned for drawing, so its last row is not the present value. Pure. */

import { countBefore, countUntil } from './sorted';
import type { Signal, SignalWindow, Track } from './types';

/** The columns of the track that are measured, with the attributes that carry them. */
const ATTRIBUTES = {
  latitude_deg: ['latitude'],
  longitude_deg: ['longitude'],
  altitude_m: ['altitude'],
  heading_deg: ['heading'],
  roll_deg: ['roll-angle'],
  fuel_kg: ['fuel', 'fuel-mass', 'fuel-remaining'],
  wind_mps: ['wind-speed'],
  wind_deg: ['wind-direction'],
} as const;

type Quantity = keyof typeof ATTRIBUTES;
export type Column = Exclude<Quantity, 'wind_mps' | 'wind_deg'>;
const QUANTITIES = Object.keys(ATTRIBUTES) as Quantity[];
const COLUMNS = QUANTITIES.filter(one => one !== 'wind_mps' && one !== 'wind_deg') as Column[];

/** The state variable that carries each quantity. */
export type Carriers = Partial<Record<Quantity, string>>;

export interface MeasuredWind {
  fromDeg: number;
  speedMps: number;
  /** Time of the older one of both samples. */
  atNs: number;
}

export interface Present {
  /** Rows of the last time: all samples of quantities that are measured, and the record's rows of others. */
  tail: Track;
  wind: MeasuredWind | null;
}

/** What a number of each unit is multiplied by, to be in the unit of its column. */
const FACTORS: Record<string, number> = {
  '': 1,
  deg: 1,
  rad: 180 / Math.PI,
  m: 1,
  ft: 0.3048,
  km: 1000,
  kg: 1,
  g: 0.001,
  lb: 0.45359237,
  'm/s': 1,
  kt: 1852 / 3600,
  'km/h': 1 / 3.6,
  'ft/s': 0.3048,
};

/** The factor of a unit; null for a unit whose numbers cannot be compared with those of the track. */
export function factorOf(unit: string): number | null {
  return FACTORS[unit] ?? null;
}

/** The signals of the vehicle that has a position; of several vehicles, of the one that is named like the agent. */
export function carriersOf(signals: readonly Signal[], agent: string | null): Carriers {
  const numbers = signals.filter(one => one.kind === 'number' && factorOf(one.unit) !== null);
  const located = [
    ...new Set(signals.filter(one => one.attribute === 'latitude').map(one => one.object.toLowerCase())),
  ];
  const object = located.length === 1 ? located[0] : located.find(one => one === agent?.toLowerCase());
  const own = numbers.filter(one => one.object.toLowerCase() === object);
  return Object.fromEntries(
    QUANTITIES.flatMap(quantity => {
      const attributes: readonly string[] = ATTRIBUTES[quantity];
      const found = own.find(one => attributes.includes(one.attribute));
      return found ? [[quantity, found.name]] : [];
    }),
  );
}

/** True if nothing is missing that may be measured later. */
export function isComplete(carriers: Carriers): boolean {
  return QUANTITIES.every(quantity => carriers[quantity] !== undefined);
}

interface Series {
  times: number[];
  values: number[];
}

/** The samples of a window. Of a pixel with several samples the last one is known only at the end of the window. */
function samplesOf(window: SignalWindow): Series {
  const factor = factorOf(window.unit) ?? 1;
  const values = window.mean.map(value => value * factor);
  if ((window.count.at(-1) ?? 1) > 1 && window.statistics)
    values[values.length - 1] = window.statistics.last * factor;
  return { times: window.t_ns, values };
}

/** The present state of the vehicle from the record's rows and the windows of its signals. */
export function presentOf(track: Track, windows: readonly SignalWindow[], carriers: Carriers): Present {
  const series: Partial<Record<Quantity, Series>> = {};
  for (const quantity of QUANTITIES) {
    const window = windows.find(one => one.name === carriers[quantity]);
    if (window && window.t_ns.length > 0) series[quantity] = samplesOf(window);
  }
  // A position needs both parts.
  if (!series.latitude_deg || !series.longitude_deg) delete series.latitude_deg;
  if (!series.latitude_deg) delete series.longitude_deg;
  return { tail: tailOf(track, series), wind: windOf(series) };
}

function windOf(series: Partial<Record<Quantity, Series>>): MeasuredWind | null {
  const [speed, direction] = [series.wind_mps, series.wind_deg];
  const [speedMps, fromDeg] = [speed?.values.at(-1), direction?.values.at(-1)];
  if (!speed || !direction || speedMps === undefined || fromDeg === undefined) return null;
  return { fromDeg, speedMps, atNs: Math.min(speed.times.at(-1) ?? 0, direction.times.at(-1) ?? 0) };
}

function tailOf(track: Track, series: Partial<Record<Quantity, Series>>): Track {
  const columns = Object.fromEntries(
    COLUMNS.map(column => {
      const measured = series[column];
      const rows = track.t_ns.map((time, index) => [time, track[column][index] ?? null] as const);
      return [
        column,
        new Map<number, number | null>(
          measured ? measured.times.map((time, index) => [time, measured.values[index] ?? null]) : rows,
        ),
      ];
    }),
  ) as Record<Column, Map<number, number | null>>;
  const times = [...new Set(COLUMNS.flatMap(column => [...columns[column].keys()]))].sort((a, b) => a - b);
  const tail: Track = {
    t_ns: times,
    latitude_deg: [],
    longitude_deg: [],
    altitude_m: [],
    heading_deg: [],
    roll_deg: [],
    ground_speed_mps: times.map(() => null),
    fuel_kg: [],
    recorded: times.length,
  };
  const last: Partial<Record<Column, number | null>> = {};
  for (const time of times) {
    for (const column of COLUMNS) last[column] = columns[column].get(time) ?? last[column] ?? null;
    const isPlaced = columns.latitude_deg.has(time) || columns.longitude_deg.has(time);
    // A position has the heading of its time; other quantities have values at the times of their samples only.
    tail.latitude_deg.push(isPlaced ? (last.latitude_deg ?? null) : null);
    tail.longitude_deg.push(isPlaced ? (last.longitude_deg ?? null) : null);
    tail.heading_deg.push(isPlaced ? (last.heading_deg ?? null) : null);
    for (const column of ['altitude_m', 'roll_deg', 'fuel_kg'] as const)
      tail[column].push(columns[column].get(time) ?? null);
  }
  return tail;
}

/** The samples of each column of a track; tracks do not change. */
const SAMPLES = new WeakMap<Track, Map<Column, Series>>();

function samplesIn(track: Track, column: Column): Series {
  const columns = SAMPLES.get(track) ?? new Map<Column, Series>();
  SAMPLES.set(track, columns);
  const known = columns.get(column);
  if (known) return known;
  const found: Series = { times: [], values: [] };
  track[column].forEach((value, index) => {
    const time = track.t_ns[index];
    if (value === null || time === undefined) return;
    found.times.push(time);
    found.values.push(value);
  });
  columns.set(column, found);
  return found;
}

/** The values of a column until an instant: of the track, and of `tail` for the time that it covers. */
export function columnUntil(
  track: Track,
  tail: Track | null,
  column: Exclude<Column, 'latitude_deg' | 'longitude_deg'>,
  atNs: number,
): { times: number[]; values: number[] } {
  const all = samplesIn(track, column);
  const recent = tail ? samplesIn(tail, column) : { times: [], values: [] };
  const until = (times: readonly number[]) => countUntil(times, atNs);
  const begin = recent.times[0];
  if (begin === undefined) {
    const count = until(all.times);
    return { times: all.times.slice(0, count), values: all.values.slice(0, count) };
  }
  // If the tail was read for an earlier instant, the rows that the track has since then follow it.
  const end = tail?.t_ns.at(-1) ?? Infinity;
  const [before, after] = [
    Math.min(countBefore(all.times, begin), until(all.times)),
    countUntil(all.times, end),
  ];
  const join = (from: readonly number[], last: readonly number[]) => [
    ...from.slice(0, before),
    ...last.slice(0, until(recent.times)),
    ...from.slice(after, Math.max(until(all.times), after)),
  ];
  return { times: join(all.times, recent.times), values: join(all.values, recent.values) };
}
