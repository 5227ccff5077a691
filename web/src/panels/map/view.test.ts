import { describe, expect, it } from 'vitest';
import type { PlanInForce, Target } from '../../record/types';
import {
  aircraftAt,
  bounds,
  countUntil,
  degreesText,
  flightBounds,
  flownUntil,
  graticuleStep,
  legend,
  onOneTurn,
  outlines,
  outsideNote,
  pathOf,
  placeAt,
  placedTargets,
  placeLabel,
  wayAhead,
  zoneAt,
  zonesAt,
} from './view';

const track = {
  t_ns: [0, 10, 20, 30],
  latitude_deg: [34, 35, null, 36],
  longitude_deg: [-118, -117, null, -117],
  altitude_m: [],
  heading_deg: [350, 10, null, null],
  roll_deg: [],
  ground_speed_mps: [],
  fuel_kg: [],
  recorded: 4,
};

describe('the aircraft', () => {
  const path = pathOf(track);

  const none = pathOf(null);
  const at = (atNs: number, tail = none) => aircraftAt(flownUntil(path, tail, atNs));

  it('is at its last sample, whatever comes after', () => {
    expect(path.times).toEqual([0, 10, 30]);
    expect(at(9.9)).toEqual({ position: [-118, 34], headingDeg: 350 });
    expect(at(10)).toEqual({ position: [-117, 35], headingDeg: 10 });
    expect(at(99)?.position).toEqual([-117, 36]);
    expect(at(-5)).toBeNull();
    expect(aircraftAt(none)).toBeNull();
  });

  it('takes the newest samples from the tail, each once, and none after the instant', () => {
    const tail = pathOf({
      ...track,
      t_ns: [8, 10, 12, 14],
      latitude_deg: [34.8, 35, 35.1, 35.2],
      longitude_deg: [-118, -117, -117, -117],
      heading_deg: [5, 10, 12, 14],
    });
    expect(flownUntil(path, tail, 13).times).toEqual([0, 8, 10, 12]);
    expect(at(13, tail)).toEqual({ position: [-117, 35.1], headingDeg: 12 });
    // The cursor has moved on, and the tail of the new instant is still to come.
    expect(flownUntil(path, tail, 31).times).toEqual([0, 8, 10, 12, 14, 30]);
    expect(flownUntil(path, tail, 3).times).toEqual([0]);
  });

  it('takes its heading from the track where none was recorded', () => {
    const bare = { ...path, headings: [null, null, null] };
    expect(aircraftAt(flownUntil(bare, none, 30))?.headingDeg).toBeCloseTo(0, 6);
  });
});

describe('targets', () => {
  const target: Target = {
    id: 'zaca',
    name: 'Zaca',
    latitude_deg: 34.7,
    longitude_deg: -119.8,
    value: 5,
    geometry: null,
    state: null,
    detail: null,
    since_ns: null,
    announced_ns: null,
    gone_ns: null,
    observed_ns: null,
    history: [
      { t_ns: 10, state: 'observing', detail: null },
      { t_ns: 10, state: 'observed', detail: 'three lines' },
    ],
  };

  it('have their state, and are known before a plan has them', () => {
    expect(placedTargets([target])[0]?.state).toBe('known');
    expect(placedTargets([{ ...target, state: 'observed' }])[0]?.state).toBe('observed');
    expect(placedTargets([{ ...target, latitude_deg: null }])).toEqual([]);
  });

  it('have a reason with its own instant, and no plan that no longer mentions them', () => {
    const skipped = (t_ns: number, detail: string) => ({ t_ns, state: 'skipped', detail });
    const left = {
      ...target,
      state: 'skipped',
      detail: 'second',
      since_ns: 100e9,
      history: [skipped(100e9, 'first'), skipped(200e9, 'second'), skipped(300e9, 'second')],
    };
    expect(placedTargets([left])[0]).toMatchObject({ sinceNs: 100e9, detail: 'since 0:03:20: second' });
    const first = { ...left, detail: 'first', history: left.history.slice(0, 1) };
    expect(placedTargets([first])[0]?.detail).toBe('first');
    const planned = { ...first, state: 'planned', detail: 'for 9:30:00' };
    expect(placedTargets([planned])[0]?.detail).toBe('planned for 9:30:00');
    const plan = { number: 4, adopted_ns: 400e9, summary: '', visits: [], route: [], left_out: [] };
    expect(placedTargets([left], plan)[0]).toMatchObject({
      state: 'known',
      sinceNs: 400e9,
      detail: 'not in plan 4 of 0:06:40',
    });
  });

  it('are counted in the legend', () => {
    const observed = { ...target, state: 'observed' };
    const entries = legend(placedTargets([observed, observed]));
    expect(entries.find(entry => entry.state === 'observed')?.count).toBe(2);
    expect(entries.some(entry => entry.state === 'known')).toBe(false);
  });

  it('may have outlines of any kind', () => {
    const ring = [
      [0, 0],
      [1, 0],
      [0, 0],
    ];
    expect(outlines({ type: 'Polygon', coordinates: [ring] })).toHaveLength(1);
    expect(
      outlines({
        type: 'Feature',
        properties: {},
        geometry: { type: 'MultiPolygon', coordinates: [[ring]] },
      }),
    ).toEqual([ring]);
    expect(outlines({ type: 'Point', coordinates: [0, 0] })).toEqual([]);
  });
});

it('the way ahead begins at the aircraft', () => {
  const route: [number, number][] = [
    [-118, 34],
    [-117, 35],
    [-116, 36],
  ];
  const plan: PlanInForce = { number: 1, adopted_ns: 0, summary: '', visits: [], route, left_out: [] };
  const aircraft = { position: [-117.1, 35] as [number, number], headingDeg: 0 };
  expect(wayAhead(plan, aircraft)).toEqual([aircraft.position, [-116, 36]]);
  expect(wayAhead(plan, null)).toEqual(route);
  expect(wayAhead(null, aircraft)).toEqual([]);
});

describe('the picture', () => {
  it('fits around everything', () => {
    expect(bounds([])).toBeNull();
    expect(
      bounds([
        [-118, 34],
        [-110, 48],
      ]),
    ).toEqual([
      [-118, 34],
      [-110, 48],
    ]);
  });

  it('writes labels side by side and leaves out those that do not fit', () => {
    const first = placeLabel(0, 0, 40, 12, []);
    expect(first?.x).toBe(9);
    const second = placeLabel(0, 2, 40, 12, first ? [first] : []);
    expect(second?.x).toBe(-49);
    const wall = { x: -500, y: -500, width: 1000, height: 1000 };
    expect(placeLabel(0, 0, 40, 12, [wall])).toBeNull();
    // A label is not cut by the edge of the map.
    const room = { width: 100, height: 50 };
    expect(placeLabel(90, 25, 40, 12, [], room)).toMatchObject({ x: 41 });
    expect(placeLabel(50, 25, 120, 12, [], room)).toBeNull();
  });

  it('has a graticule for every scale', () => {
    expect(graticuleStep(49)).toBe(5);
    expect(graticuleStep(0.03)).toBe(0.005);
    expect(degreesText(-117.85, 0.05, 'E', 'W')).toBe('117.85°W');
    expect(degreesText(44, 2, 'N', 'S')).toBe('44°N');
  });

  it('counts sorted times', () => {
    expect(countUntil([1, 2, 2, 5], 2)).toBe(3);
    expect(countUntil([], 2)).toBe(0);
  });
});

describe('a flight across the 180th meridian', () => {
  const across = pathOf({
    ...track,
    t_ns: [0, 10],
    latitude_deg: [52, 52],
    longitude_deg: [179.8, -179.8],
    heading_deg: [null, null],
  });

  it('is one way, and the map fits around it', () => {
    expect(across.positions[1]?.[0]).toBeCloseTo(180.2, 6);
    expect(placeAt(across, 5)?.[0]).toBeCloseTo(180, 6);
    expect(aircraftAt(across)?.headingDeg).toBeCloseTo(90, 6);
    const box = flightBounds([
      [178.9, 52],
      [-178.9, 53],
    ]);
    expect((box?.[1][0] ?? 0) - (box?.[0][0] ?? 0)).toBeCloseTo(2.2, 6);
  });

  it('has all its places on the turn of the view', () => {
    for (const centre of [179, -179]) {
      const [one, two] = [onOneTurn([179.8, 52], -179.5, centre), onOneTurn([-179.8, 52], -179.5, centre)];
      expect(two[0] - one[0]).toBeCloseTo(0.4, 6);
      expect(Math.abs(one[0] - centre)).toBeLessThan(2);
    }
    expect(onOneTurn([-117, 41], -114, -100)).toEqual([-117, 41]);
  });

  it('has zones where they are, and longitudes up to 180°', () => {
    const ring = (west: number, east: number) => [
      [west, 51],
      [east, 51],
      [east, 53],
      [west, 53],
      [west, 51],
    ];
    const zone = (coordinates: number[][][][]) => ({
      name: 'Across',
      geometry: { type: 'MultiPolygon' as const, coordinates },
      active_h: [],
      altitude_m_min: 0,
      altitude_m_max: null,
      permitted: false,
    });
    const zones = zonesAt(
      {
        zones: [zone([[ring(179.2, 180)], [ring(-180, -179.4)]]), zone([[ring(179.2, -179.4)]])],
        landing_places: [],
      },
      0,
      null,
    );
    for (const one of zones) {
      const longitudes = one.lines.flat().map(([longitude]) => longitude);
      expect(Math.max(...longitudes) - Math.min(...longitudes)).toBeCloseTo(1.4, 6);
      expect(zoneAt([179.7, 52], [one])).toContain('Across');
      expect(zoneAt([-179.7, 52], [one])).toContain('Across');
      expect(zoneAt([0, 52], [one])).toBeNull();
    }
    expect(degreesText(181, 1, 'E', 'W')).toBe('179°W');
  });
});

it('the map names what lies beyond its last latitude', () => {
  const at = (latitude: number) => ({ position: [10, latitude] as [number, number], headingDeg: 0 });
  const field = { latitude_deg: 86, longitude_deg: 10 } as never;
  expect(outsideNote(at(86), [], [field], [])).toBe(
    'outside of the map, which ends at 85° of latitude: aircraft, 1 landing place',
  );
  expect(outsideNote(at(84), [], [], [])).toBeNull();
});
