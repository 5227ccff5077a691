import { describe, expect, it } from 'vitest';
import type { MonitoredCondition } from '../../record/types';
import { limitWords, monitorTree } from './view';

const part = (rest: Partial<MonitoredCondition>): MonitoredCondition => ({
  kind: 'measurement',
  text: '(roll-angle aircraft-1 > 3deg)',
  holds: false,
  variable: null,
  value: null,
  limits: [],
  now: '',
  since_ns: null,
  until_ns: null,
  place: 'a.pdl:1:1',
  parts: [],
  ...rest,
});
const roll = part({
  kind: 'episode',
  holds: true,
  variable: '(roll-angle aircraft-1)',
  value: '17.48321deg',
  limits: ['> 3deg', 'for P5S'],
  since_ns: 33_423e9,
});
const names = new Map([['zaca', 'Zaca']]);

describe('the tree of monitors', () => {
  it('has values, limits and times, with measured conditions first', () => {
    const monitors = {
      at_ns: 0,
      bindings: [],
      monitors: [
        {
          task: 3,
          goal: '(observe zaca)',
          clause: 'waitfor',
          condition: part({ kind: 'event', text: '(new plan)' }),
        },
        {
          task: 9,
          goal: '(refly)',
          clause: 'waitfor',
          condition: part({ kind: 'and', parts: [roll, part({ kind: 'event', text: '(go)' })] }),
        },
      ],
    };
    const tree = monitorTree(monitors, names, 3);
    expect(tree.map(node => node.words)).toEqual(['refly · waitfor', 'observe Zaca · waitfor']);
    const leaf = tree[0]?.children[0]?.children[0];
    expect(leaf?.words).toBe('roll angle aircraft 1');
    expect([leaf?.glyph, leaf?.value, leaf?.note]).toEqual([
      '●',
      '17.48deg',
      'limit > 3deg for 5 s · since 9:17:03',
    ]);
    expect(tree[1]?.chosen).toBe(true);
    expect(monitorTree(monitors, names, null, 'REFLY')).toHaveLength(1);
  });

  it('says that the data do not decide about a variable without a sample', () => {
    const fuel = part({ variable: '(fuel uav)', value: '9kg', now: '(fuel uav) = 9kg, 4kg off' });
    const battery = part({ variable: '(battery-charge uav)', now: 'no sample yet' });
    const event = part({ kind: 'event', now: 'no such event yet' });
    const glyphs = (kind: string, ...parts: MonitoredCondition[]) => {
      const condition = part({ kind, parts });
      const monitors = {
        at_ns: 0,
        bindings: [],
        monitors: [{ task: 1, goal: '(a)', clause: 'waitfor', condition }],
      };
      const [top] = monitorTree(monitors, names, null);
      return [top?.glyph, ...(top?.children[0]?.children.map(node => node.glyph) ?? [])].join('');
    };
    expect(glyphs('or', fuel, battery)).toBe('◌○◌');
    expect(glyphs('and', fuel, battery)).toBe('○○◌');
    expect(glyphs('and', battery, battery)).toBe('◌◌◌');
    expect(glyphs('or', fuel, event)).toBe('○○○');
    expect(glyphs('not', battery)).toBe('◌◌');
  });

  it('says nothing where there is no limit', () => {
    expect(limitWords(part({}))).toBe('');
  });
});
