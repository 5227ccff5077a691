import { expect, it } from 'vitest';
import type { SignalWindow } from '../../record/types';
import { plotsSvg } from './plots';
import { samplesRows, samplesTable } from './signals';

const ROLL: SignalWindow = {
  name: '(roll-angle a<1)',
  attribute: 'roll-angle',
  object: 'a<1',
  unit: 'deg',
  kind: 'number',
  first_ns: 0,
  limits: [{ low: -3, high: 3, duration_s: 5, also: '', guarded: true, step: 's1', place: '' }],
  t_ns: [0, 5e9, 10e9],
  low: [-1, 2, 0],
  high: [1, 8, 2],
  mean: [0, 5, 1],
  count: [3, 4, 1],
  words: [],
  statistics: null,
  samples: 8,
  excursions: [{ limit: 0, from_ns: 4e9, to_ns: 6e9, peak: 8, samples: 4, raised_ns: 6e9 }],
  left_out: 0,
} as unknown as SignalWindow;
const MODE = {
  ...ROLL,
  name: '(mode a<1)',
  attribute: 'mode',
  unit: '',
  kind: 'words',
  limits: [],
  excursions: [],
  t_ns: [0, 5e9],
  low: [0, 1],
  high: [0, 1],
  mean: [0, 1],
  count: [1, 1],
  words: ['off', 'on "b"'],
} as unknown as SignalWindow;

it('plots have every value between the lowest and the highest, limits and excursions, at their times', () => {
  const svg = plotsSvg([ROLL, MODE], { fromNs: 0, toNs: 20e9 }, 12e9);
  // 64 px to 792 px are 20 s: 5 s are 182 px.
  const line = /class="line" d="([^"]*)"/.exec(svg)?.[1] ?? '';
  expect(line.match(/[ML][\d.]+/g)).toEqual(['M64', 'L246', 'L428']);
  const band = /polygon points="([^"]*)"/.exec(svg)?.[1]?.split(' ') ?? [];
  const heights = band.map(point => Number(point.split(',')[1]));
  expect(band.length).toBe(6);
  // The highest value is highest on the sheet, below the title and within the frame.
  expect(Math.min(...heights)).toBe(heights[1]);
  expect(Math.min(...heights)).toBeGreaterThan(20);
  expect(Math.max(...heights)).toBeLessThan(130);
  expect(svg).toContain('class="limit"');
  expect(/class="excursion" x="([\d.]+)".*? width="([\d.]+)"/.exec(svg)?.slice(1)).toEqual(['209.6', '72.8']);
  // A word is a step, and holds until the cursor; text is escaped.
  const steps = [...svg.matchAll(/class="line" d="([^"]*)"/g)][1]?.[1] ?? '';
  expect(steps).toMatch(/^M64 [\d.]+H246V[\d.]+H500.8V[\d.]+$/);
  expect(svg).toContain('on &quot;b&quot;');
  expect(svg).not.toMatch(/a<1/);
});

it('tables keep numbers and words apart, and rows have both in one column', () => {
  const table = samplesTable([ROLL, MODE]);
  expect(table.time_s).toEqual([0, 5, 10, 0, 5]);
  expect(table.value).toEqual([0, 5, 1, null, null]);
  expect(table.word).toEqual(['', '', '', 'off', 'on "b"']);
  expect(table.highest.slice(0, 3)).toEqual([1, 8, 2]);
  expect(samplesRows([MODE])).toEqual([
    ['signal', 'unit', 'time_s', 'value', 'lowest', 'highest', 'samples'],
    ['(mode a<1)', '', 0, 'off', null, null, 1],
    ['(mode a<1)', '', 5, 'on "b"', null, null, 1],
  ]);
});
