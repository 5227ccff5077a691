import { expect, it } from 'vitest';
import type { Signal } from '../../record/types';
import { chosenSignals, signalFaults } from './signals';

const signal = (attribute: string, object: string, kind = 'number'): Signal =>
  ({ name: `(${attribute} ${object})`, attribute, object, kind, limits: [] }) as unknown as Signal;

it('names the signals of an address that are not plotted', () => {
  const all = [signal('altitude', 'a-1'), signal('margin', 'heat'), signal('margin', 'energy')];
  const asked = ['altitude', 'altitude a-1', 'margin', 'fuel a-1'];
  expect(chosenSignals(all, asked).map(one => one.name)).toEqual(['(altitude a-1)']);
  expect(signalFaults(all, asked)).toEqual([
    'margin is measured of several objects: margin heat, margin energy.',
    'No signal fuel a-1 was measured by this time; the field above lists those that were.',
  ]);
  expect(signalFaults(all, null)).toEqual([]);
});
