import { describe, expect, it } from 'vitest';
import { advance, axisOf, clamp, otherSpeed, Pace, shift, speedFor, stepNs, zoom } from './clock';

const S = 1e9;
const hour = { fromNs: 0, toNs: 3600 * S };

describe('playing', () => {
  it('takes about a minute for a record of any length', () => {
    expect(speedFor(hour)).toBe(60);
    expect(speedFor({ fromNs: 0, toNs: 5 * S })).toBe(1);
    expect(speedFor({ fromNs: 0, toNs: 1e6 * S })).toBe(3600);
  });

  it('advances by watching time times speed and stops at the end', () => {
    expect(advance(0, 500, 60, hour)).toEqual({ atNs: 30 * S, ended: false });
    expect(advance(3599 * S, 500, 60, hour)).toEqual({ atNs: 3600 * S, ended: true });
  });

  it('changes speed in steps and stays at the ends', () => {
    expect(otherSpeed(60, 1)).toBe(120);
    expect(otherSpeed(60, -1)).toBe(30);
    expect(otherSpeed(1, -1)).toBe(1);
    expect(otherSpeed(3600, 1)).toBe(3600);
  });
});

describe('the visible range', () => {
  it('keeps the time under the pointer when zoomed', () => {
    expect(zoom(hour, hour, 900 * S, 0.5)).toEqual({ fromNs: 450 * S, toNs: 2250 * S });
  });

  it('never leaves the record', () => {
    expect(zoom(hour, hour, 900 * S, 3)).toEqual(hour);
    expect(shift({ fromNs: 10 * S, toNs: 20 * S }, hour, -60 * S)).toEqual({ fromNs: 0, toNs: 10 * S });
    expect(shift({ fromNs: 10 * S, toNs: 20 * S }, hour, 9999 * S)).toEqual({
      fromNs: 3590 * S,
      toNs: 3600 * S,
    });
  });

  it('sets the step of the arrow keys', () => {
    expect(stepNs(hour, false)).toBe(36 * S);
    expect(stepNs(hour, true)).toBe(360 * S);
    expect(clamp(-5, hour)).toBe(0);
  });
});

describe('the time axis', () => {
  const record = { fromNs: 0, toNs: 50 };

  it('is as long as the mission is planned, and longer only as far as the cursor', () => {
    expect(axisOf(record, 30, 10)).toEqual({ fromNs: 0, toNs: 30 });
    expect(axisOf(record, 30, 40)).toEqual({ fromNs: 0, toNs: 40 });
    expect(axisOf(record, 90, 50)).toEqual({ fromNs: 0, toNs: 90 });
  });

  it('is the record where no mission plans a length', () => {
    expect(axisOf(record, null, 10)).toEqual(record);
  });
});

describe('the moves of a playing cursor', () => {
  /** The instants of the moves in frames at these times. */
  const movesAt = (frames: number[]) => {
    const pace = new Pace(0);
    return frames.filter(now => pace.due(now) !== null);
  };

  it('come with every second frame while the page draws fast', () => {
    expect(movesAt([16, 33, 50, 66, 83])).toEqual([16, 50, 83]);
  });

  it('leave as much time as the drawing of the last one took', () => {
    // Drawn at 56: the next move is 80 ms after the one at 16.
    expect(movesAt([16, 56, 72, 88, 96, 112, 126])).toEqual([16, 96, 126]);
  });

  it('come ten times a second, or as often as the page can draw them', () => {
    expect(movesAt([16, 96, 112, 116, 316, 516])).toEqual([16, 116, 316, 516]);
  });

  it('move the cursor by all of the time', () => {
    const pace = new Pace(0);
    const moved = [16, 56, 72, 88, 96, 112, 126].map(now => pace.due(now) ?? 0);
    expect(moved.reduce((sum, ms) => sum + ms, 0)).toBe(126);
  });
});
