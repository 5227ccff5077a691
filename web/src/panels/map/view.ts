/** Contents of the map at an instant; pure. */

import { middleLongitude, wrapLongitude } from '../../record/longitude';
import { isInside } from '../../record/passing';
import { countUntil } from '../../record/sorted';
import type { LandingPlace, PlanInForce, Surroundings, Target, Track } from '../../record/types';
import { isUnmentioned, notInPlan, reasonSince, shownState } from '../../record/visits';
import { clock, NANOSECONDS_PER_SECOND } from '../../time/format';

export type Position = [longitudeDeg: number, latitudeDeg: number];

/** The track as positions; samples without a position are left out. */
export interface Path {
  times: number[];
  positions: Position[];
  headings: (number | null)[];
}

export interface Aircraft {
  position: Position;
  headingDeg: number;
}

export interface TargetView {
  id: string;
  name: string;
  position: Position;
  /** `known` until a plan includes it or leaves it out. */
  state: string;
  sinceNs: number | null;
  detail: string | null;
  value: number | null;
}

/** The states of targets in the order of the legend. */
export const TARGET_STATES = ['known', 'planned', 'observing', 'observed', 'skipped'] as const;

export function pathOf(track: Track | null): Path {
  const path: Path = { times: [], positions: [], headings: [] };
  track?.t_ns.forEach((time, index) => {
    const longitude = track.longitude_deg[index];
    const latitude = track.latitude_deg[index];
    if (longitude == null || latitude == null) return;
    path.times.push(time);
    // A flight across the 180th meridian continues beyond 180°, so that every two neighbours are near to each other.
    const before = path.positions.at(-1)?.[0] ?? longitude;
    path.positions.push([wrapLongitude(longitude, before), latitude]);
    path.headings.push(track.heading_deg[index] ?? null);
  });
  return path;
}

export { countUntil };

/**
 * The flown way until an instant: the samples of the path, and those of `tail`, which has all samples of the last time. Samples after the
 * instant are not used.
 */
export function flownUntil(path: Path, tail: Path, atNs: number): Path {
  const from = tail.times[0] ?? Infinity;
  const [before, after] = [countUntil(path.times, Math.min(from - 1, atNs)), countUntil(tail.times, atNs)];
  // If the tail was read for an earlier instant, the samples that the path has since then follow it.
  const last = tail.times[after - 1] ?? Number.NEGATIVE_INFINITY;
  const [again, end] = [Math.max(countUntil(path.times, last), before), countUntil(path.times, atNs)];
  const join = <T>(one: readonly T[], two: readonly T[]) => [
    ...one.slice(0, before),
    ...two.slice(0, after),
    ...one.slice(again, end),
  ];
  return {
    times: join(path.times, tail.times),
    positions: join(path.positions, tail.positions),
    headings: join(path.headings, tail.headings),
  };
}

/** The place at an instant between two flown samples, on a straight line; at the ends, the place of that sample. */
export function placeAt(flown: Path, atNs: number): Position | null {
  const index = Math.max(countUntil(flown.times, atNs) - 1, 0);
  const [from, to] = [flown.positions[index], flown.positions[index + 1]];
  const [start, end] = [flown.times[index] ?? 0, flown.times[index + 1] ?? 0];
  if (!from || !to || atNs <= start) return from ?? null;
  const share = (atNs - start) / (end - start);
  const east = wrapLongitude(to[0], from[0]) - from[0];
  return [from[0] + east * share, from[1] + (to[1] - from[1]) * share];
}

/** The aircraft at its last sample; null before the first. Where it is after that sample is not known yet. */
export function aircraftAt(flown: Path): Aircraft | null {
  const position = flown.positions.at(-1);
  if (!position) return null;
  const before = flown.positions.at(-2);
  return { position, headingDeg: flown.headings.at(-1) ?? (before ? bearing(before, position) : 0) };
}

/** The known targets that have a place, in their states; `plan` is the plan in force. */
export function placedTargets(targets: readonly Target[], plan: PlanInForce | null = null): TargetView[] {
  return targets.flatMap(target => {
    if (target.longitude_deg === null || target.latitude_deg === null) return [];
    const state = shownState(target, plan);
    const absent = plan && isUnmentioned(target, plan) ? notInPlan(plan) : null;
    return {
      id: target.id,
      name: target.name,
      position: [target.longitude_deg, target.latitude_deg] satisfies Position,
      state,
      sinceNs: state === 'observed' ? target.observed_ns : (absent?.sinceNs ?? target.since_ns),
      detail: absent?.reason ?? detailWords(target, state),
      value: target.value,
    };
  });
}

/** The reason of a target's state, with its instant where a later plan stated it. */
function detailWords(target: Target, state: string): string | null {
  if (target.detail === null) return null;
  const leftOut = state === 'observed' && target.state === 'skipped';
  const sinceNs = reasonSince(target);
  const later = target.since_ns !== null && sinceNs !== null && sinceNs > target.since_ns;
  const since = later ? `since ${clock(sinceNs / NANOSECONDS_PER_SECOND)}: ` : '';
  const planned = target.state === 'planned' ? 'planned ' : '';
  return `${leftOut ? 'left out: ' : ''}${since}${planned}${target.detail}`;
}

export interface ZoneView {
  lines: Position[][];
  /** Place of its label. */
  centre: Position;
  label: string;
  permitted: boolean;
  /** True if the zone is active now and includes the aircraft's altitude. */
  active: boolean;
}

/** The zones with their names, times and heights, and whether they are active now; permitted areas have no text. */
export function zonesAt(surroundings: Surroundings, atNs: number, altitudeM: number | null): ZoneView[] {
  const hour = atNs / NANOSECONDS_PER_SECOND / 3600;
  return surroundings.zones.map(zone => {
    const raw = outlines(zone.geometry);
    const middle = middleLongitude(raw.flat().map(([longitude]) => longitude));
    const lines = raw.map(line => wrapLine(line, middle));
    const inTime =
      zone.active_h.length === 0 || zone.active_h.some(([from, to]) => hour >= from && hour < to);
    const top = zone.altitude_m_max;
    const inHeight =
      altitudeM === null || (altitudeM >= zone.altitude_m_min && (top === null || altitudeM <= top));
    // Hours of the mission, unlike those of the civil time in the header.
    const times = zone.active_h.map(([from, to]) => `T+${hours(from)} to T+${hours(to)}`).join(', ');
    const heights = `${zone.altitude_m_min > 0 ? `${zone.altitude_m_min}–` : 'up to '}${top ?? 'any height'}${top === null ? '' : ' m'}`;
    const box = bounds(lines.flat()) ?? [
      [0, 0],
      [0, 0],
    ];
    return {
      lines,
      centre: [(box[0][0] + box[1][0]) / 2, (box[0][1] + box[1][1]) / 2],
      label: zone.permitted ? '' : [zone.name, times, heights].filter(Boolean).join(', '),
      permitted: zone.permitted,
      active: inTime && inHeight,
    };
  });
}

/** A line with longitudes within 180° of `middle`; one around the whole world remains as it is. */
function wrapLine(line: readonly Position[], middle: number): Position[] {
  const [low, high] = bounds(line) ?? [[0], [0]];
  if (high[0] - low[0] >= 360) return [...line];
  return line.map(([longitude, latitude]) => [wrapLongitude(longitude, middle), latitude]);
}

/** Text about the zones at a place, without permitted areas: name, times, heights, and whether they are active; null if there are none. */
export function zoneAt(place: Position, zones: readonly ZoneView[]): string | null {
  const around = (zone: ZoneView): Position => [wrapLongitude(place[0], zone.centre[0]), place[1]];
  const here = zones.filter(zone => !zone.permitted && zone.lines.some(line => isInside(around(zone), line)));
  if (here.length === 0) return null;
  return here.map(zone => `${zone.label} (${zone.active ? 'active now' : 'not active now'})`).join('; ');
}

function hours(value: number): string {
  const minutes = Math.round(value * 60);
  return `${Math.floor(minutes / 60)}:${String(minutes % 60).padStart(2, '0')}`;
}

/**
 * The rest of the plan's way, from the aircraft to the last place. It is cut at the point nearest to the aircraft, because the flown
 * track shows the way behind.
 */
export function wayAhead(plan: PlanInForce | null, aircraft: Aircraft | null): Position[] {
  const route = (plan?.route ?? []) as Position[];
  if (!aircraft || route.length === 0) return route;
  const [longitude, latitude] = aircraft.position;
  const shrink = Math.cos((latitude * Math.PI) / 180);
  let [nearest, best] = [0, Number.POSITIVE_INFINITY];
  route.forEach(([east, north], index) => {
    const distance = Math.hypot((wrapLongitude(east, longitude) - longitude) * shrink, north - latitude);
    if (distance < best) [nearest, best] = [index, distance];
  });
  return [aircraft.position, ...route.slice(nearest + 1)];
}

/** The legend: each state with its number of targets. */
export function legend(targets: readonly TargetView[]): { state: string; count: number }[] {
  return TARGET_STATES.map(state => ({
    state,
    count: targets.filter(target => target.state === state).length,
  })).filter(({ state, count }) => state !== 'known' || count > 0);
}

/** The corners around a flight's places, with longitudes beyond 180° if it is on both sides of that meridian; null without places. */
export function flightBounds(places: readonly Position[]): [Position, Position] | null {
  const middle = middleLongitude(places.map(([longitude]) => longitude));
  return bounds(places.map(([longitude, latitude]) => [wrapLongitude(longitude, middle), latitude]));
}

/**
 * A place as the map draws it for a flight around the longitude `middle`, while the view is around `centre`: all places of the flight are
 * on the same turn around the earth, the one nearest to the view.
 */
export function onOneTurn([longitude, latitude]: Position, middle: number, centre: number): Position {
  const turn = wrapLongitude(middle, centre) - middle;
  return [wrapLongitude(longitude, middle) + turn, latitude];
}

/** The greatest latitude of the map's projection (Web Mercator). */
const MAP_LATITUDE_DEG = 85.05;

/** `outside of the map, which ends at 85° of latitude: aircraft, 5 targets, 1 zone`; null if everything is on the map. */
export function outsideNote(
  aircraft: Aircraft | null,
  targets: readonly TargetView[],
  landingPlaces: readonly LandingPlace[],
  zones: readonly ZoneView[],
): string | null {
  const beyond = (latitude: number) => Math.abs(latitude) > MAP_LATITUDE_DEG;
  const counted = (count: number, word: string) =>
    count === 0 ? [] : [`${count} ${word}${count === 1 ? '' : 's'}`];
  const parts = [
    ...(aircraft && beyond(aircraft.position[1]) ? ['aircraft'] : []),
    ...counted(targets.filter(target => beyond(target.position[1])).length, 'target'),
    ...counted(landingPlaces.filter(place => beyond(place.latitude_deg)).length, 'landing place'),
    ...counted(zones.filter(zone => beyond(zone.centre[1])).length, 'zone'),
  ];
  return parts.length === 0 ? null : `outside of the map, which ends at 85° of latitude: ${parts.join(', ')}`;
}

/** South-west and north-east corners around all positions; null if there are none. */
export function bounds(positions: readonly Position[]): [Position, Position] | null {
  if (positions.length === 0) return null;
  const low: Position = [Number.POSITIVE_INFINITY, Number.POSITIVE_INFINITY];
  const high: Position = [Number.NEGATIVE_INFINITY, Number.NEGATIVE_INFINITY];
  for (const [longitude, latitude] of positions) {
    low[0] = Math.min(low[0], longitude);
    low[1] = Math.min(low[1], latitude);
    high[0] = Math.max(high[0], longitude);
    high[1] = Math.max(high[1], latitude);
  }
  return [low, high];
}

/** All positions of a GeoJSON geometry's outlines, as lines to draw. */
export function outlines(geometry: Target['geometry']): Position[][] {
  if (!geometry) return [];
  switch (geometry.type) {
    case 'Feature':
      return outlines(geometry.geometry);
    case 'FeatureCollection':
      return geometry.features.flatMap(feature => outlines(feature.geometry));
    case 'GeometryCollection':
      return geometry.geometries.flatMap(part => outlines(part));
    case 'LineString':
      return [geometry.coordinates as Position[]];
    case 'Polygon':
    case 'MultiLineString':
      return geometry.coordinates as Position[][];
    case 'MultiPolygon':
      return geometry.coordinates.flat() as Position[][];
    default:
      return [];
  }
}

/** Distance between lines of the graticule for a view this many degrees wide. */
export function graticuleStep(widthDeg: number): number {
  const steps = [0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 30];
  return steps.find(step => widthDeg / step <= 10) ?? 45;
}

/** `44°N`, `117.85°W`. */
export function degreesText(value: number, step: number, positive: string, negative: string): string {
  const decimals = Math.max(0, Math.ceil(-Math.log10(step) - 1e-9));
  // A view across the 180th meridian has longitudes beyond 180°.
  const shown = wrapLongitude(value, 0);
  return `${Math.abs(shown).toFixed(decimals)}°${shown < 0 ? negative : positive}`;
}

export { type Box, placeLabel } from '../../parts/labels';

function bearing(from: Position, to: Position): number {
  const radians = Math.PI / 180;
  const east = (wrapLongitude(to[0], from[0]) - from[0]) * Math.cos(from[1] * radians);
  return (Math.atan2(east, to[1] - from[1]) / radians + 360) % 360;
}
