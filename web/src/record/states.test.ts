import { describe, expect, it } from 'vitest';
import { withoutTruth } from './source';
import { marginsOf, navigationNote, stateAlarms } from './states';
import type { SignalWindow } from './types';

const words = (attribute: string, object: string, changes: [number, string][]): SignalWindow =>
  ({
    name: `(${attribute} ${object})`,
    attribute,
    object,
    unit: '',
    kind: 'words',
    t_ns: changes.map(([t]) => t * 1e9),
    mean: changes.map((_, index) => index),
    words: changes.map(([, word]) => word),
    limits: [],
    excursions: [],
  }) as unknown as SignalWindow;

describe('watched states', () => {
  const navigation = words('navigation-state', 'uav-1', [
    [0, 'good'],
    [1005, 'degraded'],
    [3000, 'good'],
  ]);

  it('names a navigation failure from its report until it is over', () => {
    expect(stateAlarms([navigation], 1004e9)).toEqual([]);
    expect(navigationNote([navigation], 1004e9)).toBeNull();
    const [alarm] = stateAlarms([navigation], 2400e9);
    expect([alarm?.words, alarm?.open, alarm?.atNs]).toEqual(['navigation of uav 1 degraded', true, 1005e9]);
    expect(alarm?.cause).toContain('the true ones are not known');
    expect(navigationNote([navigation], 2400e9)).toBe(
      'position uncertain: navigation degraded since T+0:16:45',
    );
    expect(stateAlarms([navigation], 3001e9)[0]?.cause).toMatch(/; until T\+0:50:00$/);
    expect(navigationNote([navigation], 3001e9)).toBeNull();
  });

  it('names a requirement at risk with its least margin by then', () => {
    const state = words('requirement-state', 'terrain', [
      [9, 'at-risk'],
      [30, 'kept'],
    ]);
    const margin = {
      ...words('margin', 'terrain', []),
      kind: 'number',
      unit: 's',
      t_ns: [9e9, 12e9, 40e9],
      low: [-3.82, -4.5, -9],
    } as SignalWindow;
    expect(marginsOf([navigation, state])).toEqual(['(margin terrain)']);
    const at = (atNs: number) => stateAlarms([state, margin], atNs)[0];
    expect([at(10e9)?.words, at(10e9)?.cause, at(10e9)?.open]).toEqual([
      'requirement terrain at risk',
      'margin -3.82 s at T+0:00:09, below its limit; 1.0 s',
      true,
    ]);
    expect(at(50e9)?.cause).toBe('margin -4.5 s at T+0:00:12, below its limit; 21 s; until T+0:00:30');
    expect([at(50e9)?.open, at(50e9)?.signal]).toEqual([false, '(margin terrain)']);
  });

  it('names a requirement that cannot be judged, without the margin of an earlier time', () => {
    const state = words('requirement-state', 'mission-end', [
      [5, 'kept'],
      [20, 'unknown'],
    ]);
    const margin = { ...words('margin', 'mission-end', []), t_ns: [5e9, 25e9], low: [7, 8] } as SignalWindow;
    const [alarm] = stateAlarms([state, margin], 80e9);
    expect([alarm?.words, alarm?.open, alarm?.signal]).toEqual([
      'requirement mission end not judged',
      true,
      '(requirement-state mission-end)',
    ]);
    expect(alarm?.cause).toBe('the vehicle does not report what its margin is computed from; 1 min 00 s');
  });

  it('shows no true values of the simulator', () => {
    const signals = ['truth-edr', 'edr'].map(attribute => ({ ...navigation, attribute }));
    expect(withoutTruth({ signals }).signals.map(one => one.attribute)).toEqual(['edr']);
  });
});
