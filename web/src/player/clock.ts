/** Movement of the cursor over a record; pure. */

import type { Growth } from '../record/types';
import { NANOSECONDS_PER_SECOND } from '../time/format';

/** Playing speeds: seconds of mission for one second of watching. */
export const SPEEDS = [1, 2, 5, 10, 30, 60, 120, 300, 600, 1200, 3600] as const;

/** Time in which a record is played back, unless the user chooses a speed. */
const WATCH_S = 60;

export interface Range {
  fromNs: number;
  toNs: number;
}

/**
 * The span of the time axis at an instant: the mission as planned, and longer only as far as the cursor. How long the flight lasts is
 * not known before its end. A record without a mission has no plan; its axis is the record.
 */
export function axisOf(record: Range, plannedNs: number | null, atNs: number): Range {
  const { fromNs } = record;
  return { fromNs, toNs: plannedNs === null ? record.toNs : Math.max(fromNs + 1, plannedNs, atNs) };
}

/** The slowest speed that plays the whole record in at most a minute; the fastest speed if none does. */
export function speedFor(range: Range): number {
  const wanted = (range.toNs - range.fromNs) / NANOSECONDS_PER_SECOND / WATCH_S;
  return SPEEDS.find(speed => speed >= wanted) ?? SPEEDS[SPEEDS.length - 1] ?? 1;
}

/** The next faster (1) or slower (-1) speed. */
export function otherSpeed(speed: number, direction: 1 | -1): number {
  const at = SPEEDS.findIndex(candidate => candidate >= speed);
  return SPEEDS[(at < 0 ? SPEEDS.length - 1 : at) + direction] ?? speed;
}

export function clamp(atNs: number, range: Range): number {
  return Math.min(Math.max(atNs, range.fromNs), range.toNs);
}

/** The cursor after `elapsedMs` of playing, and whether it is at the end. */
export function advance(
  atNs: number,
  elapsedMs: number,
  speed: number,
  range: Range,
): { atNs: number; ended: boolean } {
  const next = atNs + elapsedMs * 1e6 * speed;
  return next >= range.toNs ? { atNs: range.toNs, ended: true } : { atNs: next, ended: false };
}

/** The step of an arrow key: a hundredth of the visible range, but at least a millisecond; a coarse step is ten times as long. */
export function stepNs(visible: Range, coarse: boolean): number {
  return Math.max((visible.toNs - visible.fromNs) / 100, 1e6) * (coarse ? 10 : 1);
}

/** `visible` scaled around `atNs`, kept inside `whole`. */
export function zoom(visible: Range, whole: Range, atNs: number, factor: number): Range {
  const length = Math.min(Math.max((visible.toNs - visible.fromNs) * factor, 1e6), whole.toNs - whole.fromNs);
  const share = (atNs - visible.fromNs) / Math.max(visible.toNs - visible.fromNs, 1);
  return shift({ fromNs: atNs - share * length, toNs: atNs + (1 - share) * length }, whole, 0);
}

/** `visible` moved by `byNs`, kept inside `whole`. */
export function shift(visible: Range, whole: Range, byNs: number): Range {
  const length = visible.toNs - visible.fromNs;
  const fromNs = Math.min(
    Math.max(visible.fromNs + byNs, whole.fromNs),
    Math.max(whole.toNs - length, whole.fromNs),
  );
  return { fromNs, toNs: Math.min(fromNs + length, whole.toNs) };
}

/** True if a record has new contents. While a flight is paused, accepted commands add batches at the same mission time. */
export function hasGrown(before: Growth, after: Growth): boolean {
  return before.end_ns !== after.end_ns || before.batches !== after.batches || before.status !== after.status;
}

/** A frame that takes longer than this, in milliseconds, has left no time for anything else. */
const BUSY_MS = 34;
/** Least and longest time between two moves of a playing cursor, unless a move itself takes longer. */
const [MOVE_MS_MIN, MOVE_MS_MAX] = [30, 100];

/** The moves of a playing cursor: some thirty in a second, or fewer, so that a page that draws slowly has as much time for its user's keys. */
export class Pace {
  private frameAt: number;
  private isDrawing = false;
  private restMs = 0;

  constructor(private movedAt: number) {
    this.frameAt = movedAt;
  }

  /** The time since the last move if the cursor moves in the frame of `now`; null while it rests. Times are in milliseconds. */
  due(now: number): number | null {
    // The first frame after a move begins when the move has been drawn.
    const drawnMs = now - this.frameAt;
    if (this.isDrawing) this.restMs = drawnMs > BUSY_MS ? Math.min(2 * drawnMs, MOVE_MS_MAX) : MOVE_MS_MIN;
    this.frameAt = now;
    const elapsedMs = now - this.movedAt;
    this.isDrawing = elapsedMs >= this.restMs;
    if (!this.isDrawing) return null;
    this.movedAt = now;
    return elapsedMs;
  }
}
