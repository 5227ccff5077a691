import { describe, expect, it } from 'vitest';
import { shortValue, withDurations } from './duration';

describe('durations and values', () => {
  it('are words', () => {
    expect(withDurations('for P1M5S')).toBe('for 1 min 5 s');
    expect(withDurations('holds for P2.503871S so far')).toBe('holds for 2.504 s so far');
    expect(withDurations('PX and P4')).toBe('PX and P4');
  });

  it('are short', () => {
    expect(shortValue('17.483216deg')).toBe('17.48deg');
    expect(shortValue('-0.0312999')).toBe('-0.0313');
    expect(shortValue('T5 ended at 0:53:04.689')).toBe('T5 ended at 0:53:04');
    expect(shortValue('120 of 4.5')).toBe('120 of 4.5');
  });
});
