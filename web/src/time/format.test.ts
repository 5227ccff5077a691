import { describe, expect, it } from 'vitest';
import { civilTime, missionTime, plannedClock, plannedMinute, span, ticks } from './format';

const S = 1e9;

describe('mission time', () => {
  it('shows hours, minutes and seconds, rounded down', () => {
    expect(missionTime(0)).toBe('T+0:00:00');
    expect(missionTime(3784.99 * S)).toBe('T+1:03:04');
    expect(missionTime(12.5 * S, 1)).toBe('T+0:00:12.5');
    expect(missionTime(-65 * S)).toBe('T-0:01:05');
  });

  it('becomes civil time only when the epoch is known', () => {
    expect(civilTime(60 * S, '2007-09-08T01:00:00Z')).toBe('2007-09-08 01:01:00Z');
    expect(civilTime(60 * S, null)).toBeNull();
    expect(civilTime(60 * S, 'yesterday')).toBeNull();
  });
});

describe('spans', () => {
  it('take the unit that a reader expects', () => {
    expect(span(7500 * S)).toBe('2 h 05 min');
    expect(span(200 * S)).toBe('3 min 20 s');
    expect(span(4.2 * S)).toBe('4.2 s');
    expect(span(0.12 * S)).toBe('120 ms');
  });
});

describe('ticks', () => {
  it('are at round times and not more than asked for', () => {
    const marks = ticks(100 * S, 72_000 * S, 8);
    expect(marks.length).toBeLessThanOrEqual(8);
    expect(marks[0]).toEqual({ atNs: 10_800 * S, label: '3:00:00' });
  });

  it('have decimals where a record is short', () => {
    expect(ticks(0, 1 * S, 5).map(mark => mark.label)).toContain('0:00:00.2');
    expect(ticks(5, 5, 5)).toEqual([]);
  });
});

it('rounds planned times as the reasons of the planner do', () => {
  expect([plannedClock(2079.855e9), plannedMinute(2079.855e9)]).toEqual(['0:34:40', '0:34']);
  expect(plannedMinute(2099.9e9)).toBe('0:35');
});
