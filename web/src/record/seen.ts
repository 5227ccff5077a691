/** What the map asks of a record next to the generated types: the ground seen, and the vehicle. */

import type { Signal } from './types';

/** A position as GeoJSON writes it. */
type Pair = [longitudeDeg: number, latitudeDeg: number];

/** A scan line on the ground; `valid` if it counts for coverage. */
export interface SeenLine {
  t_ns: number;
  left: Pair;
  right: Pair;
  valid: boolean;
}

/** The ground that sensors have seen, from the observation model. */
export interface Footprints {
  /** The ground between neighbouring lines of a swath is seen. */
  swaths: { lines: SeenLine[] }[];
  pictures: { t_ns: number; corners: Pair[] }[];
}

/** The mission score if the flight ended at the instant that was asked for, in points. */
export interface ScoreSoFar {
  /** Observations count that were made until this instant. */
  counted_ns: number;
  benefits: number;
  costs: number;
  score: number;
}

/** What the mission's files say, known from the start. */
export interface MissionFacts {
  kind: 'fixed-wing' | 'rotorcraft';
  landing_distance_m_max: number | null;
  /** In which images of targets have their full worth. */
  windows: { target: string; look: string; from_ns: number; to_ns: number }[];
}

/** The signals that the map draws along the flown track. */
export function airSignals(signals: readonly Signal[]): { wind: [string, string] | null; links: Signal[] } {
  const named = (attribute: string) => signals.find(signal => signal.attribute === attribute)?.name;
  const [speed, direction] = [named('wind-speed'), named('wind-direction')];
  return {
    wind: speed && direction ? [speed, direction] : null,
    links: signals.filter(signal => signal.attribute === 'signal-level' && signal.kind === 'number'),
  };
}
