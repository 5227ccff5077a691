import { describe, expect, it } from 'vitest';
import { isEqual, keptNames, keptRows } from './kept';

describe('equal values', () => {
  it('have equal members', () => {
    const row = { id: 'a', visits: [{ fromNs: 1, toNs: 2 }], left: null };
    expect(isEqual(row, structuredClone(row))).toBe(true);
    expect(isEqual(row, { ...row, visits: [{ fromNs: 1, toNs: 3 }] })).toBe(false);
    expect(isEqual(row, { ...row, visits: [] })).toBe(false);
    expect(isEqual(row, { ...row, left: { reason: 'no time' } })).toBe(false);
    expect(isEqual(row, { ...row, more: undefined })).toBe(false);
    expect(isEqual({ a: undefined }, { b: undefined })).toBe(false);
    expect(isEqual([], {})).toBe(false);
    expect(isEqual(null, {})).toBe(false);
  });
});

describe('rows', () => {
  it('are those before where they are equal, in the new order', () => {
    const before = [
      { id: 'a', state: 'planned' },
      { id: 'b', state: 'planned' },
    ];
    const after = [
      { id: 'b', state: 'planned' },
      { id: 'c', state: 'planned' },
      { id: 'a', state: 'observed' },
    ];
    const rows = keptRows(before, after);
    expect(rows).toEqual(after);
    expect(rows[0]).toBe(before[1]);
    expect(rows[2]).toBe(after[2]);
  });
});

describe('names', () => {
  it('are those before while they are equal', () => {
    const before = keptNames(new Map(), [{ id: 'a', name: 'Alder' }]);
    expect(keptNames(before, [{ id: 'a', name: 'Alder' }])).toBe(before);
    expect(keptNames(before, [{ id: 'a', name: 'Birch' }]).get('a')).toBe('Birch');
    expect(keptNames(before, []).size).toBe(0);
  });
});
