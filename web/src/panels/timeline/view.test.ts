import { describe, expect, it } from 'vitest';
import { axisOf } from '../../player/clock';
import { type Bar, unpackBands, unpackRows } from '../../record/bands';
import type { Band, Target, Timeline, Track, Trouble } from '../../record/types';
import {
  barAt,
  blocksOf,
  cursorValues,
  densityOf,
  type LaneRow,
  laneAtWork,
  laneOf,
  layLanes,
  lineOf,
  NAMES_PX,
  ROW_PX,
  scaleOf,
  scrollTo,
  stripsOf,
  troubleMarks,
  troubleWords,
  valueWords,
  visitsOf,
} from './view';

const visible = { fromNs: 0, toNs: 1000 };
const scale = scaleOf(visible, NAMES_PX + 1000);
const bar = (task: number, from_ns: number, to_ns: number): Bar => ({
  task,
  state: 'ongoing',
  from_ns,
  to_ns,
});

describe('the scale', () => {
  it('goes there and back', () => {
    expect(scale.x(0)).toBe(NAMES_PX);
    expect(scale.x(1000)).toBe(NAMES_PX + 1000);
    expect(scale.at(scale.x(321))).toBeCloseTo(321, 9);
  });
});

it('the values of the cursor are seconds and end with the axis', () => {
  const axis = axisOf({ fromNs: 0, toNs: 3_580.889e9 }, 3_600e9, 1_200.5e9);
  expect(cursorValues(axis, 1_200.5e9)).toEqual({ min: 0, max: 3600, now: 1200 });
});

describe('lanes', () => {
  const lane = { tag: 'line', goal: '(fly-line (zaca 1))', depth: 2, active_ns: 5, bands: [] };
  const timeline: Timeline = {
    from_ns: 0,
    to_ns: 1000,
    at_ns: 1000,
    pixel_ns: 1,
    more: { lanes: 0, tasks: 0, bands: [] },
    lanes: [
      { ...lane, tasks: 1, rows: [[[1, 0, 2, 500]]] },
      {
        ...lane,
        tasks: 2,
        rows: [
          [[2, 0, 2, 100]],
          [
            [3, 50, 2, 100],
            [4, 300, 2, 0],
          ],
        ],
      },
    ],
  };
  const { lanes, height } = layLanes(timeline);

  it('are as high as their rows, and named by what their tasks share', () => {
    expect(height).toBe(3 * ROW_PX);
    expect(lanes.map(row => [row.y, row.name])).toEqual([
      [0, 'fly line'],
      [ROW_PX, 'fly line'],
    ]);
    expect(layLanes(null).height).toBe(0);
  });

  it('can be hit, marks of no length too', () => {
    expect(barAt(lanes, scale.x(250), 3, scale)?.task).toBe(1);
    expect(barAt(lanes, scale.x(75), ROW_PX + 3, scale)?.task).toBe(2);
    expect(barAt(lanes, scale.x(75), 2 * ROW_PX + 3, scale)?.task).toBe(3);
    expect(barAt(lanes, scale.x(301), 2 * ROW_PX + 3, scale)?.task).toBe(4);
    expect(barAt(lanes, scale.x(600), 3, scale)).toBeNull();
    expect(barAt(lanes, scale.x(75), 999, scale)).toBeNull();
  });

  it('come into sight when their task is chosen, or is at work', () => {
    expect(laneOf(lanes, 3)?.y).toBe(ROW_PX);
    expect(laneOf(lanes, 99)).toBeUndefined();
    expect(laneAtWork(lanes, 60)?.y).toBe(ROW_PX);
    expect(laneAtWork(lanes, 400)?.y).toBe(0);
    expect(laneAtWork(lanes, 900)).toBeUndefined();
    const far = { ...(lanes[0] as LaneRow), y: 300 };
    expect(scrollTo(far, 0, 100)).toBe(300 + 2 * ROW_PX - 100);
    expect(scrollTo(far, 400, 100)).toBe(300 - ROW_PX);
    expect(scrollTo(far, 250, 100)).toBe(250);
  });

  it('unpack runs of bars: each bar begins where the one before it ends', () => {
    expect(
      unpackRows([
        [
          [7, 1000, 0, 5, 2, 10, 3, 1],
          [7, 2000, 1, 0],
        ],
        [],
      ]),
    ).toEqual([
      [
        { task: 7, state: 'pending', from_ns: 1000, to_ns: 1005 },
        { task: 7, state: 'ongoing', from_ns: 1005, to_ns: 1015 },
        { task: 7, state: 'interrupted', from_ns: 1015, to_ns: 1016 },
        { task: 7, state: 'enabled', from_ns: 2000, to_ns: 2000 },
      ],
      [],
    ]);
  });

  it('draw bars under a pixel as one block', () => {
    const tiny = Array.from({ length: 500 }, (_, index) => bar(index, index / 10, index / 10 + 0.1));
    const blocks = blocksOf(tiny, visible, 1000, scale);
    expect(blocks.length).toBe(1);
    expect(blocks[0]?.width).toBeGreaterThan(49);
    expect(blocksOf([bar(1, -50, 20), bar(2, 2000, 3000)], visible, 1000, scale)).toEqual([
      { x: NAMES_PX, width: 20, state: 'ongoing', task: 1 },
    ]);
    const known = blocksOf([bar(1, 0, 400), bar(2, 600, 700)], visible, 300, scale);
    expect(known).toEqual([{ x: NAMES_PX, width: 300, state: 'ongoing', task: 1 }]);
  });

  const band = (pixel: number, end: number, count: number, ongoing: number): Band => [
    pixel,
    end - pixel,
    count,
    1000 * ongoing,
  ];

  it('measure bands in pixels, up to what is known', () => {
    const window = { from_ns: 100, to_ns: 500, at_ns: 450, pixel_ns: 100 };
    expect(unpackBands([band(0, 2, 7, 0.25), band(3, 4, 1, 1)], window)).toEqual([
      { from_ns: 100, to_ns: 300, count: 7, ongoing: 0.25 },
      { from_ns: 400, to_ns: 450, count: 1, ongoing: 1 },
    ]);
  });

  it('draw dense stretches with their counts, and the lanes left out as the last one', () => {
    const bands = [band(0, 1, 5, 0.5), band(1, 2, 7, 1), band(500, 501, 3, 0)];
    const dense = layLanes({
      ...timeline,
      lanes: [
        { ...lane, tasks: 15, rows: [], bands },
        { ...lane, tasks: 20, rows: [[[1, 0, 2, 500]]], bands },
      ],
      more: { lanes: 312, tasks: 400, bands },
    });
    expect(dense.lanes.map(row => [row.name, row.height])).toEqual([
      ['fly line', ROW_PX],
      ['fly line', 2 * ROW_PX],
      ['312 more lanes', ROW_PX],
    ]);
    const stretches = unpackBands(bands, timeline);
    const runs = densityOf(stretches, visible, 1000, scale);
    expect(runs.map(run => run.count)).toEqual([12, 3]);
    expect(runs[0]?.blocks.map(block => block.share)).toEqual([0.5, 1]);
    expect(densityOf(stretches, visible, 400, scale)).toHaveLength(1);
  });
});

describe('failures and faults', () => {
  const trouble = (t_ns: number, kind: Trouble['kind'], subject: string): Trouble => ({
    t_ns,
    kind,
    subject,
    cause: '',
    task: null,
    failed_child: null,
    handler_task: null,
    targets: [],
    cause_kind: null,
    handler: null,
    place: null,
    target: null,
  });

  it('that touch are one mark with a count; none is lost', () => {
    const troubles = [10, 12, 300, 5000].map(at => trouble(at, 'failed', 'it'));
    expect(troubleMarks(troubles, visible, scale).map(mark => mark.troubles.length)).toEqual([2, 1]);
  });

  it('have words', () => {
    const names = new Map([['zaca', 'Zaca']]);
    expect(troubleWords(trouble(0, 'interrupted', '(fly line from (1 2) to (3 4))'), names)).toBe(
      'interrupted: fly line',
    );
    expect(troubleWords(trouble(0, 'failed', '(scan zaca once along ((1 2) (3 4)))'), names)).toBe(
      'failed: scan Zaca',
    );
    expect(troubleWords(trouble(0, 'left-out', 'zaca'), names)).toBe('left out: Zaca');
  });
});

it('visits last from observing to the result; a skipped target is a mark', () => {
  const target = (id: string, history: [number, string][]): Target => ({
    id,
    name: id,
    latitude_deg: 0,
    longitude_deg: 0,
    value: 1,
    geometry: null,
    state: null,
    detail: null,
    since_ns: null,
    announced_ns: null,
    gone_ns: null,
    observed_ns: null,
    history: history.map(([t_ns, state]) => ({ t_ns, state, detail: null })),
  });
  const visits = visitsOf(
    [
      target('b', [
        [0, 'planned'],
        [30, 'observing'],
        [50, 'observed'],
      ]),
      target('a', [[20, 'skipped']]),
      target('c', [[60, 'observing']]),
    ],
    99,
  );
  expect(visits.map(visit => [visit.id, visit.fromNs, visit.toNs, visit.state])).toEqual([
    ['a', 20, 20, 'skipped'],
    ['b', 30, 50, 'observed'],
    ['c', 60, 99, 'observing'],
  ]);
});

describe('strips', () => {
  const times = Array.from({ length: 5000 }, (_, index) => index / 5);
  const track: Track = {
    t_ns: times,
    latitude_deg: [],
    longitude_deg: [],
    altitude_m: times.map((_, index) => (index === 2500 ? 900 : index % 7)),
    heading_deg: [],
    roll_deg: times.map(() => null),
    ground_speed_mps: [],
    fuel_kg: times.map(() => 5),
    recorded: 5000,
  };

  it('are made of quantities that were recorded, up to the cursor', () => {
    expect(stripsOf(track, null, 1000).map(made => made.name)).toEqual(['altitude', 'fuel']);
    expect(stripsOf(track, null, 499).map(made => made.high)).toEqual([6, 5]);
    expect(stripsOf(null, null, 0)).toEqual([]);
  });

  it('keep every peak in few points', () => {
    const [altitude] = stripsOf(track, null, 1000);
    if (!altitude) throw new Error('there is no altitude');
    const points = lineOf(altitude, visible, scale, 0, 100);
    expect(points.length).toBeLessThanOrEqual(2002);
    expect(Math.min(...points.map(point => point[1]))).toBe(0);
    const altitudeAt = (atNs: number) => stripsOf(track, null, atNs).map(one => valueWords(one, atNs))[0];
    expect(altitudeAt(500)).toBe('900 m');
    expect(altitudeAt(-1)).toBe('');
  });

  it('state the last measurement, not the last row of the thinned track, and the age of an old one', () => {
    const thinned = { ...track, t_ns: [0, 10e9], altitude_m: [5, 7], roll_deg: [1, 2], fuel_kg: [9, 9] };
    const tail = { ...thinned, t_ns: [10e9, 12e9, 14e9], altitude_m: [7, 8, null], roll_deg: [2, 2.5, 0.4] };
    const words = (atNs: number) => stripsOf(thinned, tail, atNs).map(one => valueWords(one, atNs));
    expect(words(14.5e9)).toEqual(['8 m', '0.4 °', '9 kg']);
    expect(words(13e9)[1]).toBe('2.5 °');
    expect(words(11e9)[1]).toBe('2.0 °');
    expect(words(100e9)[1]).toBe('0.4 °, 1 min 26 s ago');
  });
});
