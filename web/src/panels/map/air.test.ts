import { describe, expect, it } from 'vitest';
import type { SignalWindow } from '../../record/types';
import {
  circleAround,
  positionNote,
  readLayer,
  seenPatches,
  weakLinks,
  weakNote,
  windArrows,
  windNote,
  windText,
} from './air';

function windowOf(
  attribute: string,
  t_ns: number[],
  low: number[],
  limits: { low: number }[] = [],
): SignalWindow {
  return { attribute, unit: '', t_ns, low, high: low, mean: low, limits } as unknown as SignalWindow;
}

const PATH = {
  times: [0, 100],
  positions: [[0, 40] as [number, number], [1, 40] as [number, number]],
  headings: [90, 90],
};

describe('wind and link', () => {
  it('stands where the aircraft was when the wind was measured', () => {
    const arrows = windArrows(
      [windowOf('wind-speed', [0, 50], [10, 12.86]), windowOf('wind-direction', [0, 40], [350, 276])],
      PATH,
    );
    expect(arrows.map(arrow => [arrow.fromDeg, arrow.position[0]])).toEqual([
      [350, 0],
      [276, 0.5],
    ]);
    expect(windText(arrows[1] as (typeof arrows)[0])).toBe('wind from 276° at 25 kt');
    expect(windText({ ...(arrows[1] as (typeof arrows)[0]), speedMps: 0.2 })).toBe('calm');
    expect(windArrows([], PATH)).toEqual([]);
    const many = Array.from({ length: 400 }, (_, index) => index);
    const dense = [windowOf('wind-speed', many, many), windowOf('wind-direction', many, many)];
    expect(windArrows(dense, PATH).length).toBeLessThanOrEqual(41);
    expect(windArrows(dense, PATH)[1]).toMatchObject({ speedMps: 10, fromDeg: 10, atNs: 10 });
  });

  it('state the last measurement, and its time if it is old', () => {
    const wind = { fromDeg: 235, speedMps: 22, atNs: 100e9 };
    expect(windNote(wind, 103e9)).toBe('wind from 235° at 43 kt, measured');
    expect(windNote(wind, 200e9)).toBe('wind from 235° at 43 kt, measured at T+0:01:40');
    expect(windNote(wind, 99e9)).toBeNull();
    expect(positionNote({ ...PATH, times: [0, 100e9] }, 130e9)).toBeNull();
    expect(positionNote({ ...PATH, times: [0, 100e9] }, 200e9)).toBe('aircraft at its position of T+0:01:40');
    expect(positionNote({ ...PATH, times: [] }, 200e9)).toBeNull();
  });

  it('is weak only below the limit of the mission', () => {
    const level = [1, 0.1, 0.05, 0.4];
    const limited = windowOf('signal-level', [0, 10, 20, 30], level, [{ low: 0.2 }]);
    expect(weakLinks([limited], 40)).toEqual([{ fromNs: 10, toNs: 30 }]);
    expect(weakLinks([windowOf('signal-level', [0, 10], [0, 0])], 40)).toEqual([]);
  });
});

describe('the ground seen', () => {
  const line = (t_ns: number, valid: boolean) =>
    ({ t_ns, left: [0, t_ns], right: [1, t_ns], valid }) as const;
  const footprints = {
    swaths: [
      {
        lines: [line(0, true), line(1, true), line(2, false), line(3, false)].map(one => ({
          ...one,
          left: [...one.left] as [number, number],
          right: [...one.right] as [number, number],
        })),
      },
    ],
    pictures: [
      {
        t_ns: 9,
        corners: [
          [0, 0],
          [1, 0],
          [1, 1],
        ] as [number, number][],
      },
    ],
  };
  it('has a band for each validity and nothing of later', () => {
    expect(seenPatches(footprints, 10).map(patch => [patch.valid, patch.outline.length])).toEqual([
      [true, 4],
      [false, 4],
      [true, 3],
    ]);
    expect(seenPatches(footprints, 1)).toHaveLength(1);
    expect(seenPatches(null, 1)).toEqual([]);
  });
});

describe('layers of the user', () => {
  it('reads GeoJSON and says what is wrong with other files', () => {
    const good = {
      type: 'Feature',
      geometry: {
        type: 'LineString',
        coordinates: [
          [1, 2],
          [3, 4],
        ],
      },
    };
    expect(readLayer('a.json', JSON.stringify(good))).toEqual({
      name: 'a.json',
      lines: [
        [
          [1, 2],
          [3, 4],
        ],
      ],
      points: [],
    });
    expect(readLayer('a', '{')).toMatch(/^a is not JSON/);
    expect(readLayer('a', '{"type": "Topology"}')).toMatch(/^a is not GeoJSON/);
    expect(readLayer('a', '{"type": "FeatureCollection", "features": []}')).toBe('a has no positions');
    expect(readLayer('a', '{"type": "Point", "coordinates": [500000, 4000000]}')).toMatch(/expected degrees/);
    expect(readLayer('a', '{"type": "Point", "coordinates": ["1", 2]}')).toMatch(/not GeoJSON/);
  });
});

it('draws a circle of its radius', () => {
  const [north] = circleAround([10, 45], 111_195);
  expect(north?.[1]).toBeCloseTo(46, 2);
});

it('names the last time of a weak link, which may be too short to be seen', () => {
  const weak = [
    { fromNs: 60e9, toNs: 90e9 },
    { fromNs: 100e9, toNs: 130e9 },
  ];
  const note = 'dotted track: link below its limit, last';
  expect(weakNote(weak, 50e9)).toBeNull();
  expect(weakNote(weak, 95e9)).toBe(`${note} T+0:01:00 to T+0:01:30`);
  expect(weakNote(weak, 120e9)).toBe(`${note} T+0:01:40 to now`);
});
