import { describe, expect, it } from 'vitest';
import { carriersOf, columnUntil, isComplete, presentOf } from './measured';
import type { Signal, SignalWindow, Track } from './types';

const signal = (attribute: string, object: string, unit = '', kind = 'number'): Signal =>
  ({ name: `(${attribute} ${object})`, attribute, object, unit, kind, limits: [] }) as unknown as Signal;
const window = (name: string, samples: [number, number][], rest: Partial<SignalWindow> = {}): SignalWindow =>
  ({
    name,
    unit: '',
    t_ns: samples.map(([time]) => time),
    mean: samples.map(([, value]) => value),
    count: samples.map(() => 1),
    statistics: null,
    ...rest,
  }) as unknown as SignalWindow;
const row: Track = {
  t_ns: [10, 20],
  latitude_deg: [34, 35],
  longitude_deg: [-118, -117],
  altitude_m: [100, 200],
  heading_deg: [1, 2],
  roll_deg: [5, 1.6],
  ground_speed_mps: [9, 9],
  fuel_kg: [3, 3],
  recorded: 2,
};

describe('the carriers of the state', () => {
  it('are the signals of the vehicle with a position', () => {
    const signals = [
      signal('latitude', 'uav', 'deg'),
      signal('roll-angle', 'uav', 'deg'),
      signal('roll-angle', 'camera', 'deg'),
      signal('fuel-mass', 'uav', 'lb'),
      signal('altitude', 'uav', 'furlong'),
    ];
    expect(carriersOf(signals, 'pilot')).toEqual({
      latitude_deg: '(latitude uav)',
      roll_deg: '(roll-angle uav)',
      fuel_kg: '(fuel-mass uav)',
    });
    expect(isComplete(carriersOf(signals, 'pilot'))).toBe(false);
    const two = [...signals, signal('latitude', 'other', 'deg')];
    expect(carriersOf(two, 'other')).toEqual({ latitude_deg: '(latitude other)' });
    expect(carriersOf(two, null)).toEqual({});
  });
});

describe('the present state', () => {
  it('has all samples of measured quantities, and the rows of the others', () => {
    const carriers = {
      latitude_deg: 'lat',
      longitude_deg: 'lon',
      roll_deg: 'roll',
      fuel_kg: 'fuel',
      wind_mps: 'speed',
      wind_deg: 'direction',
    };
    const windows = [
      window('lat', [
        [10, 34],
        [22, 35.2],
      ]),
      window('lon', [
        [10, -118],
        [22, -117.2],
      ]),
      window('roll', [
        [20, 1.6],
        [23, 0.4],
      ]),
      window('fuel', [[21, 2]], { unit: 'lb' }),
      window('speed', [[15, 30]], { unit: 'kt', count: [3], statistics: { last: 40 } as never }),
      window('direction', [[14, 235]]),
    ];
    const { tail, wind } = presentOf(row, windows, carriers);
    expect(tail.t_ns).toEqual([10, 20, 21, 22, 23]);
    expect(tail.latitude_deg).toEqual([34, null, null, 35.2, null]);
    expect(tail.heading_deg).toEqual([1, null, null, 2, null]);
    expect(tail.altitude_m).toEqual([100, 200, null, null, null]);
    expect(tail.roll_deg).toEqual([null, 1.6, null, null, 0.4]);
    expect(tail.fuel_kg[2]).toBeCloseTo(0.907, 3);
    expect(wind?.speedMps).toBeCloseTo((40 * 1852) / 3600, 6);
    expect([wind?.fromDeg, wind?.atNs]).toEqual([235, 14]);
  });

  it('has the rows of the record for quantities that are not measured', () => {
    const { tail, wind } = presentOf(row, [], {});
    expect(tail.t_ns).toEqual(row.t_ns);
    expect([tail.latitude_deg, tail.roll_deg]).toEqual([row.latitude_deg, row.roll_deg]);
    expect(wind).toBeNull();
    // A latitude without a longitude is not a position.
    const half = presentOf(row, [window('lat', [[22, 36]])], { latitude_deg: 'lat', longitude_deg: 'lon' });
    expect(half.tail.latitude_deg).toEqual([34, 35]);
  });
});

it('a column is that of the track, then of the tail, then again of the track', () => {
  const track = { ...row, t_ns: [0, 10, 30], roll_deg: [1, 2, 3] };
  const tail = { ...row, t_ns: [9, 12, 14], roll_deg: [null, 7, 8] };
  expect(columnUntil(track, tail, 'roll_deg', 40)).toEqual({
    times: [0, 10, 12, 14, 30],
    values: [1, 2, 7, 8, 3],
  });
  expect(columnUntil(track, tail, 'roll_deg', 13)).toEqual({ times: [0, 10, 12], values: [1, 2, 7] });
  expect(columnUntil(track, null, 'roll_deg', 10)).toEqual({ times: [0, 10], values: [1, 2] });
});
