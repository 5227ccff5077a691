import { expect, it } from 'vitest';
import { tokenIn } from './session';

it('finds a token in the fragment only', () => {
  expect(tokenIn('#token=abc123')).toBe('abc123');
  expect(tokenIn('')).toBe(null);
  expect(tokenIn('#t=5')).toBe(null);
});
