import { describe, expect, it } from 'vitest';
import type { Target } from '../../record/types';
import { compareRows } from './view';

const target = (id: string, history: [number, string][]): Target =>
  ({
    id,
    name: id,
    state: history.at(-1)?.[1] ?? null,
    history: history.map(([t_ns, state]) => ({ t_ns, state, detail: null })),
  }) as never;

describe('two flights', () => {
  it('differ where states or begins of visits do', () => {
    const first = [
      target('same', [
        [5e9, 'observing'],
        [9e9, 'observed'],
      ]),
      target('later', [[5e9, 'observing']]),
      target('only', []),
    ];
    const second = [
      target('same', [
        [5.4e9, 'observing'],
        [9e9, 'observed'],
      ]),
      target('later', [[8e9, 'observing']]),
    ];
    const rows = compareRows(first, second, 20e9);
    expect(rows.map(row => [row.id, row.differs])).toEqual([
      ['later', true],
      ['only', true],
      ['same', false],
    ]);
    expect(rows[0]?.words).toBe('observing 0:00:05, observing 0:00:08');
    expect(rows[1]?.states).toEqual(['known', 'not known']);
  });
});
