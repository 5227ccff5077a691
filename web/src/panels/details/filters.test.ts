import { describe, expect, it } from 'vitest';
import { commandOf, NO_FILTER, parseFilters, taskOf } from './filters';

describe('filters of the trace', () => {
  it('read task numbers', () => {
    expect([taskOf('T12'), taskOf(' 12 '), taskOf('x'), taskOf('')]).toEqual([12, 12, null, null]);
  });

  it('are also a command', () => {
    expect(commandOf('a.apex', { ...NO_FILTER, kinds: 'transition', task: 3, window: true }, 60, 90)).toBe(
      'apex trace a.apex --type transition --object T3 --from 60s --to 90s',
    );
  });

  it('survive what is not one', () => {
    expect(parseFilters('[{"name": "a", "find": "x"}, 5, {"find": "y"}]')).toEqual([
      { ...NO_FILTER, name: 'a', find: 'x' },
    ]);
    expect(parseFilters('{')).toEqual([]);
    expect(parseFilters(null)).toEqual([]);
  });
});
