import { expect, it } from 'vitest';
import { placeNames } from './labels';

it('puts names where they lie on no symbol and on no other name, and counts the others', () => {
  const symbols = [10, 12, 14, 16, 18, 20, 22, 24].map(x => ({ x, y: 30, name: `name ${x}` }));
  const { names, lost } = placeNames(symbols, () => 40, 13, { width: 120, height: 60 });
  expect(names.length + lost).toBe(8);
  expect(names.length).toBeGreaterThan(1);
  for (const [index, one] of names.entries())
    for (const other of names.slice(index + 1)) {
      const apart =
        one.x + 40 <= other.x || other.x + 40 <= one.x || one.y + 13 <= other.y || other.y + 13 <= one.y;
      expect(apart, `${one.name} and ${other.name}`).toBe(true);
    }
});
