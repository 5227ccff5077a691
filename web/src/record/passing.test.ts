import { expect, it } from 'vitest';
import { seenInPassing } from './passing';
import type { Footprints, Target } from './types';

const target = (id: string, longitude_deg: number, more: Partial<Target> = {}): Target =>
  ({
    id,
    longitude_deg,
    latitude_deg: 0,
    geometry: null,
    gone_ns: null,
    observed_ns: null,
    history: [],
    ...more,
  }) as Target;
const square = (east: number, size = 1): [number, number][] => [
  [east - size, -size],
  [east + size, -size],
  [east + size, size],
  [east - size, size],
];

it('names the first picture or valid scan lines that have a target without a visit', () => {
  const line = (t_ns: number, east: number, valid = true) => ({
    t_ns,
    left: [east, 1] as [number, number],
    right: [east, -1] as [number, number],
    valid,
  });
  const footprints: Footprints = {
    pictures: [
      { t_ns: 5, corners: square(10) },
      { t_ns: 9, corners: square(10) },
    ],
    swaths: [{ lines: [line(1, 20), line(2, 22), line(3, 24, false)] }],
  };
  const targets = [
    target('picture', 10.5),
    target('swath', 21),
    target('invalid', 23),
    target('elsewhere', 50),
    target('visited', 10, { observed_ns: 7 }),
  ];
  expect([...seenInPassing(targets, footprints, 10)]).toEqual([
    ['picture', 5],
    ['swath', 2],
  ]);
  expect([...seenInPassing(targets, footprints, 4)]).toEqual([['swath', 2]]);
  expect(seenInPassing(targets, null, 10).size).toBe(0);
});
