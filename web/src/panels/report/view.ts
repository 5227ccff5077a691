/** The drawings of the printable report; pure. */

import { middleLongitude, wrapLongitude } from '../../record/longitude';
import type { Footprints, SignalWindow, Target, Track } from '../../record/types';

export type Point = [x: number, y: number];

/** Projection from degrees to a drawing of a given width: plate carrée around the middle, north up. */
export interface Chart {
  width: number;
  height: number;
  point(longitudeDeg: number, latitudeDeg: number): Point;
}

/** A chart that holds all positions with a margin; none without positions. */
export function chartOf(
  positions: readonly (readonly [number, number])[],
  width: number,
  heightMax: number,
): Chart | null {
  const middle = middleLongitude(positions.map(([longitude]) => longitude));
  const longitudes = positions.map(([longitude]) => wrapLongitude(longitude, middle));
  const latitudes = positions.map(([, latitude]) => latitude);
  if (positions.length === 0) return null;
  const [west, east] = [Math.min(...longitudes), Math.max(...longitudes)];
  const [south, north] = [Math.min(...latitudes), Math.max(...latitudes)];
  const shrink = Math.cos((((south + north) / 2) * Math.PI) / 180);
  const [wide, high] = [Math.max((east - west) * shrink, 1e-4), Math.max(north - south, 1e-4)];
  const margin = 10;
  const scale = Math.min((width - 2 * margin) / wide, (heightMax - 2 * margin) / high);
  const height = high * scale + 2 * margin;
  const left = (width - wide * scale) / 2;
  return {
    width,
    height,
    point: (longitude, latitude) => [
      round(left + (wrapLongitude(longitude, middle) - west) * shrink * scale),
      round(margin + (north - latitude) * scale),
    ],
  };
}

/** Points of an SVG polyline. */
export function pointsOf(chart: Chart, positions: readonly (readonly [number, number])[]): string {
  return positions.map(([longitude, latitude]) => chart.point(longitude, latitude).join(',')).join(' ');
}

/** The flown positions in a stretch of time. */
export function flownBetween(track: Track, fromNs: number, toNs: number): [number, number][] {
  return track.t_ns.flatMap((time, index) => {
    const [longitude, latitude] = [track.longitude_deg[index], track.latitude_deg[index]];
    if (time < fromNs || time > toNs || longitude == null || latitude == null) return [];
    return [[longitude, latitude] as [number, number]];
  });
}

/** The ground seen in a stretch of time as outlines. */
export function seenBetween(
  footprints: Footprints,
  fromNs: number,
  toNs: number,
): { outline: [number, number][]; valid: boolean }[] {
  const swaths = footprints.swaths.flatMap(({ lines }) => {
    const inside = lines.filter(line => line.t_ns >= fromNs && line.t_ns <= toNs);
    // Each pair of neighbouring lines is a separate patch, so that invalid lines stay visible between valid ones.
    return inside.slice(1).map((line, index) => {
      const before = inside[index] ?? line;
      return {
        outline: [before.left, before.right, line.right, line.left],
        valid: before.valid && line.valid,
      };
    });
  });
  const pictures = footprints.pictures
    .filter(picture => picture.t_ns >= fromNs && picture.t_ns <= toNs)
    .map(picture => ({ outline: picture.corners, valid: true }));
  return [...swaths, ...pictures];
}

/** Outlines of a target's ground. */
export function ringsOf(geometry: Target['geometry']): [number, number][][] {
  if (!geometry) return [];
  if (geometry.type === 'Polygon') return geometry.coordinates as [number, number][][];
  if (geometry.type === 'MultiPolygon') return geometry.coordinates.flat() as [number, number][][];
  if (geometry.type === 'LineString') return [geometry.coordinates as [number, number][]];
  return [];
}

/** A signal as the points of a polyline in a box, with the band of its limits. */
export function stripOf(
  window: SignalWindow | undefined,
  fromNs: number,
  toNs: number,
  width: number,
  height: number,
): { points: string; band: { y: number; height: number } | null; low: number; high: number } | null {
  if (!window || window.t_ns.length === 0) return null;
  const limit = window.limits.find(one => one.low !== null && one.high !== null);
  const low = Math.min(...window.low, limit?.low ?? Number.POSITIVE_INFINITY);
  const high = Math.max(...window.high, limit?.high ?? Number.NEGATIVE_INFINITY);
  const range = high - low || 1;
  const y = (value: number) => round(height - ((value - low) / range) * height);
  const x = (time: number) =>
    round(((Math.min(Math.max(time, fromNs), toNs) - fromNs) / (toNs - fromNs || 1)) * width);
  const points = window.t_ns.flatMap((time, index) => [
    `${x(time)},${y(window.low[index] ?? low)}`,
    `${x(time)},${y(window.high[index] ?? low)}`,
  ]);
  const band =
    limit && limit.low !== null && limit.high !== null
      ? { y: y(limit.high), height: y(limit.low) - y(limit.high) }
      : null;
  return { points: points.join(' '), band, low, high };
}

function round(value: number): number {
  return Math.round(value * 10) / 10;
}
