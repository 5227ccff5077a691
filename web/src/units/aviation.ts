/** Units of aviation for display: records and PDL keep their units, operators read feet, knots and nautical miles. Pure. */

/** How numbers of a unit are shown: value in the record's unit times `factor`. */
export interface ShownUnit {
  unit: string;
  factor: number;
}

const FEET_PER_METRE = 1 / 0.3048;
const KNOTS_PER_METRE_PER_SECOND = 3600 / 1852;
const FEET_PER_MINUTE = 60 / 0.3048;
const NAUTICAL_MILES_PER_METRE = 1 / 1852;

/** The unit in which a state variable is shown. `name` is its attribute, with its object if that determines the quantity. */
export function shownUnit(name: string, unit: string): ShownUnit {
  if (unit === 'deg') return { unit: '°', factor: 1 };
  if (unit === 'm' && /altitude|height|terrain/.test(name)) return { unit: 'ft', factor: FEET_PER_METRE };
  if (unit === 'm' && /distance/.test(name)) return { unit: 'nm', factor: NAUTICAL_MILES_PER_METRE };
  if (unit === 'm/s' && name.includes('vertical-speed')) return { unit: 'ft/min', factor: FEET_PER_MINUTE };
  if (unit === 'm/s') return { unit: 'kt', factor: KNOTS_PER_METRE_PER_SECOND };
  return { unit, factor: 1 };
}

/** A number with about three or four significant digits, and no fraction from a thousand on. */
export function shownNumber(value: number): string {
  const size = Math.abs(value);
  if (size >= 1000) return value.toFixed(0);
  if (size >= 100) return value.toFixed(1);
  if (size >= 10) return value.toFixed(2);
  return value.toFixed(size >= 1 || size === 0 ? 2 : 3);
}

/** A number with its unit; a degree sign follows the number without a space. */
export function withUnit(value: number, unit: string): string {
  if (unit === '') return shownNumber(value);
  return unit === '°' ? `${shownNumber(value)}°` : `${shownNumber(value)} ${unit}`;
}
