/** Wind, link and the seen ground as shown on the map; pure. */

import { factorOf, type MeasuredWind } from '../../record/measured';
import type { Footprints, SignalWindow } from '../../record/types';
import { missionTime, NANOSECONDS_PER_SECOND } from '../../time/format';
import { type Path, type Position, placeAt } from './view';

/** A measured wind at a place of the flown track. */
export interface WindArrow {
  position: Position;
  fromDeg: number;
  speedMps: number;
  atNs: number;
}

/** Number of winds that are drawn along the track. */
const WINDS_MAX = 40;

/** Measured winds along the track at equal distances in time, oldest first. */
export function windArrows(windows: readonly SignalWindow[], flown: Path): WindArrow[] {
  const of = (attribute: string) => windows.find(window => window.attribute === attribute);
  const [speed, direction] = [of('wind-speed'), of('wind-direction')];
  if (!speed || !direction) return [];
  const [factor, angle] = [factorOf(speed.unit) ?? 1, factorOf(direction.unit) ?? 1];
  const [first, last] = [speed.t_ns[0] ?? 0, speed.t_ns.at(-1) ?? 0];
  const stepNs = (last - first) / WINDS_MAX;
  let next = first;
  return speed.t_ns.flatMap((atNs, index) => {
    if (atNs < next) return [];
    // For a direction the last sample up to that time applies, because the mean of 359° and 1° would be 180°.
    const at = direction.t_ns.findLastIndex(time => time <= atNs);
    const [fromDeg, speedMps] = [direction.low[at], speed.mean[index]];
    const position = placeAt(flown, atNs);
    if (fromDeg === undefined || speedMps === undefined || !position) return [];
    next += stepNs * Math.ceil((atNs + 1 - next) / Math.max(stepNs, 1));
    return [{ position, fromDeg: fromDeg * angle, speedMps: speedMps * factor, atNs }];
  });
}

/** Age from which a measurement is shown with its time. */
const OLD_NS = 60 * NANOSECONDS_PER_SECOND;

/** `wind from 276° at 25 kt, measured`: the last measurement by the instant, with its time if it is old. */
export function windNote(wind: MeasuredWind | null, atNs: number): string | null {
  if (!wind || wind.atNs > atNs) return null;
  const at = atNs - wind.atNs > OLD_NS ? ` at ${missionTime(wind.atNs)}` : '';
  return `${windText(wind)}, measured${at}`;
}

/** `aircraft at its position of T+0:52:10`, if no later position is known; null while its position is recent. */
export function positionNote(flown: Path, atNs: number): string | null {
  const last = flown.times.at(-1);
  if (last === undefined || atNs - last <= OLD_NS) return null;
  return `aircraft at its position of ${missionTime(last)}`;
}

/** The stretches of time in which a link was below a limit of the mission. */
export function weakLinks(
  windows: readonly SignalWindow[],
  atNs: number,
): { fromNs: number; toNs: number }[] {
  return windows
    .filter(window => window.attribute === 'signal-level')
    .flatMap(window => {
      const limit = Math.max(...window.limits.map(one => one.low ?? Number.NEGATIVE_INFINITY));
      if (!Number.isFinite(limit)) return [];
      const weak: { fromNs: number; toNs: number }[] = [];
      window.t_ns.forEach((fromNs, index) => {
        if ((window.low[index] ?? limit) >= limit) return;
        const toNs = window.t_ns[index + 1] ?? atNs;
        const last = weak.at(-1);
        if (last && last.toNs === fromNs) last.toNs = toNs;
        else weak.push({ fromNs, toNs });
      });
      return weak;
    });
}

/** `dotted track: link below its limit, last T+9:00:21 to T+9:03:20`; null without such a stretch by the instant. */
export function weakNote(weak: readonly { fromNs: number; toNs: number }[], atNs: number): string | null {
  const last = weak.findLast(one => one.fromNs < atNs);
  if (!last) return null;
  const end = last.toNs >= atNs ? 'now' : missionTime(last.toNs);
  return `dotted track: link below its limit, last ${missionTime(last.fromNs)} to ${end}`;
}

/** The part of the flown track in a stretch of time. */
export function pathBetween(path: Path, fromNs: number, toNs: number): Position[] {
  return path.positions.filter((_, index) => {
    const time = path.times[index] as number;
    return time >= fromNs && time <= toNs;
  });
}

/** A patch of seen ground: a band of scan lines that are all valid or all invalid, or a picture. */
export interface SeenPatch {
  outline: Position[];
  valid: boolean;
}

/** The number of scan lines and pictures by an instant. */
export function seenBy(footprints: Footprints | null, atNs: number): number {
  if (!footprints) return 0;
  const lines = footprints.swaths.map(swath => swath.lines.filter(line => line.t_ns <= atNs).length);
  const pictures = footprints.pictures.filter(picture => picture.t_ns <= atNs).length;
  return lines.reduce((sum, count) => sum + count, pictures);
}

/** The ground seen by an instant, as outlines to fill. */
export function seenPatches(footprints: Footprints | null, atNs: number): SeenPatch[] {
  if (!footprints) return [];
  const patches: SeenPatch[] = [];
  for (const { lines } of footprints.swaths) {
    let left: Position[] = [];
    let right: Position[] = [];
    let valid = lines[0]?.valid ?? true;
    const close = () => {
      if (left.length > 1) patches.push({ outline: [...left, ...right.toReversed()], valid });
    };
    for (const line of lines) {
      if (line.t_ns > atNs) break;
      if (line.valid !== valid) {
        close();
        [left, right, valid] = [[], [], line.valid];
      }
      left.push(line.left);
      right.push(line.right);
    }
    close();
  }
  for (const picture of footprints.pictures)
    if (picture.t_ns <= atNs) patches.push({ outline: picture.corners, valid: true });
  return patches;
}

/** A circle on the ground, as positions; good to a percent at 400 km. */
export function circleAround([longitude, latitude]: Position, radiusM: number): Position[] {
  const earthM = 6_371_000;
  const angle = radiusM / earthM;
  const start = (latitude * Math.PI) / 180;
  return Array.from({ length: 97 }, (_, index) => {
    const bearing = (index / 96) * 2 * Math.PI;
    const north = Math.asin(
      Math.sin(start) * Math.cos(angle) + Math.cos(start) * Math.sin(angle) * Math.cos(bearing),
    );
    const east = Math.atan2(
      Math.sin(bearing) * Math.sin(angle) * Math.cos(start),
      Math.cos(angle) - Math.sin(start) * Math.sin(north),
    );
    return [longitude + (east * 180) / Math.PI, (north * 180) / Math.PI];
  });
}

/** Wind of less than half a knot: it has no direction. */
export const CALM = 'calm';

/** `wind from 276° at 25 kt`. */
export function windText(wind: Pick<WindArrow, 'fromDeg' | 'speedMps'>): string {
  const knots = Math.round((wind.speedMps * 3600) / 1852);
  if (knots === 0) return CALM;
  return `wind from ${String(Math.round(wind.fromDeg + 360) % 360).padStart(3, '0')}° at ${knots} kt`;
}

/** A layer added by the user; it never leaves the browser. */
export interface UserLayer {
  name: string;
  lines: Position[][];
  points: Position[];
}

/** Maximum number of positions of a user's layer. */
const LAYER_POSITIONS_MAX = 200_000;

/** A GeoJSON file as a layer, or its problem in one sentence. */
export function readLayer(name: string, text: string): UserLayer | string {
  let data: unknown;
  try {
    data = JSON.parse(text);
  } catch (error) {
    return `${name} is not JSON: ${error instanceof Error ? error.message : error}`;
  }
  const layer: UserLayer = { name, lines: [], points: [] };
  if (!collect(data, layer))
    return `${name} is not GeoJSON: expected a FeatureCollection, a Feature or a geometry`;
  const count = layer.points.length + layer.lines.reduce((sum, line) => sum + line.length, 0);
  if (count === 0) return `${name} has no positions`;
  if (count > LAYER_POSITIONS_MAX)
    return `${name} has ${count} positions; the map draws at most ${LAYER_POSITIONS_MAX}`;
  const all = [...layer.points, ...layer.lines.flat()];
  const wrong = all.find(([east, north]) => !(Math.abs(east) <= 180 && Math.abs(north) <= 90));
  if (wrong)
    return `${name} has the position ${wrong.join(', ')}; expected degrees of longitude and latitude`;
  return layer;
}

function collect(data: unknown, layer: UserLayer): boolean {
  if (typeof data !== 'object' || data === null || !('type' in data)) return false;
  const object = data as { type: string; features?: unknown[]; geometry?: unknown; geometries?: unknown[] };
  const { coordinates } = data as { coordinates?: unknown };
  switch (object.type) {
    case 'FeatureCollection':
      return Array.isArray(object.features) && object.features.every(feature => collect(feature, layer));
    case 'Feature':
      return object.geometry === null || collect(object.geometry, layer);
    case 'GeometryCollection':
      return Array.isArray(object.geometries) && object.geometries.every(part => collect(part, layer));
    case 'Point':
      return addPositions([coordinates], layer.points);
    case 'MultiPoint':
      return addPositions(coordinates, layer.points);
    case 'LineString':
      return addLines([coordinates], layer);
    case 'MultiLineString':
    case 'Polygon':
      return addLines(coordinates, layer);
    case 'MultiPolygon':
      return Array.isArray(coordinates) && coordinates.every(polygon => addLines(polygon, layer));
    default:
      return false;
  }
}

function addLines(lines: unknown, layer: UserLayer): boolean {
  if (!Array.isArray(lines)) return false;
  return lines.every(line => {
    const positions: Position[] = [];
    layer.lines.push(positions);
    return addPositions(line, positions);
  });
}

function addPositions(list: unknown, to: Position[]): boolean {
  if (!Array.isArray(list)) return false;
  return list.every(position => {
    if (!Array.isArray(position) || typeof position[0] !== 'number' || typeof position[1] !== 'number')
      return false;
    to.push([position[0], position[1]]);
    return true;
  });
}
