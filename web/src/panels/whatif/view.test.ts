import { describe, expect, it } from 'vitest';
import { inputsOf, progressOf } from './view';

describe('what if', () => {
  it('sends messages after the instant', () => {
    expect(inputsOf(' (a)\n\n(b) ', 9.5e9)).toEqual([
      { t: 10, event: '(a)' },
      { t: 10, event: '(b)' },
    ]);
  });

  it('tells how far it is', () => {
    expect(progressOf({ now_ns: 1800e9 } as never, 3600e9)).toBe('T+0:30:00, 50 % of the flight');
  });
});
