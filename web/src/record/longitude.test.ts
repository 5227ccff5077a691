import { expect, it } from 'vitest';
import { middleLongitude, wrapLongitude } from './longitude';

it('the middle of longitudes on both sides of the 180th meridian is there', () => {
  expect(Math.abs(middleLongitude([178.9, 179.6, -179.4, -178.9]))).toBeCloseTo(180, 6);
  expect(middleLongitude([-118.2, -110.5])).toBeCloseTo(-114.5, 6);
  expect(middleLongitude([7.2])).toBeCloseTo(7.5, 6);
  expect(middleLongitude([])).toBe(0);
});

it('a longitude is that within half a turn', () => {
  expect(wrapLongitude(-178.9, 179.5)).toBeCloseTo(181.1, 6);
  expect(wrapLongitude(179.6, -179.5)).toBeCloseTo(-180.4, 6);
  expect(wrapLongitude(-117, -114)).toBe(-117);
  expect(wrapLongitude(180, 0)).toBe(180);
  expect(wrapLongitude(-180, 0)).toBe(-180);
});
