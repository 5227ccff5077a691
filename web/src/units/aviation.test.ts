import { expect, it } from 'vitest';
import { shownUnit, withUnit } from './aviation';

const shown = (name: string, unit: string, value: number) => {
  const by = shownUnit(name, unit);
  return withUnit(value * by.factor, by.unit);
};

it('shows heights in feet, speeds in knots, distances in nautical miles', () => {
  expect(shown('altitude', 'm', 3048)).toBe('10000 ft');
  expect(shown('margin terrain', 'm', 36.576)).toBe('120.0 ft');
  expect(shown('ground-speed', 'm/s', 61.7333)).toBe('120.0 kt');
  expect(shown('vertical-speed', 'm/s', -6.096)).toBe('-1200 ft/min');
  expect(shown('distance-flown', 'm', 222_240)).toBe('120.0 nm');
});

it('keeps other units', () => {
  expect(shown('roll-angle', 'deg', -3)).toBe('-3.00°');
  expect(shown('signal-level', '', 0.02)).toBe('0.020');
  expect(shown('fuel', 'kg', 1769)).toBe('1769 kg');
  expect(shown('footprint-width', 'm', 8000)).toBe('8000 m');
});
