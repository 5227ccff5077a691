import { expect, it } from 'vitest';
import { revealPx } from './reveal';

const panel = { top: 100, bottom: 500 };

it('an entry in sight stays where it is', () => {
  expect(revealPx({ top: 200, bottom: 220 }, panel)).toBe(0);
});

it('an entry below or above comes into sight, not under what stays at the top', () => {
  expect(revealPx({ top: 490, bottom: 510 }, panel)).toBe(46);
  expect(revealPx({ top: 110, bottom: 130 }, panel)).toBe(-86);
});

it('of an entry taller than the panel its beginning is in sight', () => {
  expect(revealPx({ top: 300, bottom: 900 }, panel)).toBe(104);
});
