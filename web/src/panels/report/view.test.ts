import { describe, expect, it } from 'vitest';
import type { SignalWindow } from '../../record/types';
import { chartOf, flownBetween, pointsOf, seenBetween, stripOf } from './view';

describe('the chart of a report', () => {
  it('holds all positions, north up', () => {
    const chart = chartOf(
      [
        [10, 45],
        [12, 47],
      ],
      200,
      300,
    );
    if (!chart) throw new Error('there is no chart');
    const [south, north] = [chart.point(10, 45), chart.point(12, 47)];
    expect(south[0]).toBeLessThan(north[0]);
    expect(south[1]).toBeGreaterThan(north[1]);
    expect(Math.min(south[0], north[1])).toBeGreaterThanOrEqual(10 - 0.1);
    expect(chart.height).toBeLessThanOrEqual(300);
    expect(pointsOf(chart, [[10, 45]])).toBe(south.join(','));
    expect(chartOf([], 10, 10)).toBeNull();
  });

  it('shows only the stretch of time of a visit', () => {
    const track = { t_ns: [0, 10, 20], longitude_deg: [1, 2, 3], latitude_deg: [4, null, 6] } as never;
    expect(flownBetween(track, 5, 30)).toEqual([[3, 6]]);
    const line = (t_ns: number, valid: boolean) => ({
      t_ns,
      valid,
      left: [0, t_ns] as [number, number],
      right: [1, t_ns] as [number, number],
    });
    const footprints = { swaths: [{ lines: [line(0, true), line(1, true), line(2, false)] }], pictures: [] };
    expect(seenBetween(footprints, 0, 9).map(patch => patch.valid)).toEqual([true, false]);
    expect(seenBetween(footprints, 2, 9)).toEqual([]);
  });

  it('keeps the limits of a signal in its strip', () => {
    const window = {
      t_ns: [0, 100],
      low: [-1, 0],
      high: [1, 2],
      limits: [{ low: -3, high: 3 }],
    } as unknown as SignalWindow;
    const strip = stripOf(window, 0, 100, 100, 60);
    expect(strip?.band).toEqual({ y: 0, height: 60 });
    expect(strip?.points.split(' ')).toHaveLength(4);
    expect(stripOf(undefined, 0, 1, 1, 1)).toBeNull();
  });
});

it('a chart across the 180th meridian is as wide as the flight', () => {
  const chart = chartOf(
    [
      [179, 52],
      [-179, 53],
    ],
    400,
    200,
  );
  const [west, middle, east] = [179, 180, -179].map(longitude => chart?.point(longitude, 52)[0] ?? 0);
  expect((west ?? 0) < (middle ?? 0) && (middle ?? 0) < (east ?? 0)).toBe(true);
});
