import { expect, it } from 'vitest';
import { placeAfter } from './roving';

it('moves between rows and within one, and stays inside', () => {
  const sizes = [2, 1, 2];
  const from = (row: number, item: number) => (key: string) => placeAfter(key, { row, item }, sizes);
  expect(from(0, 1)('ArrowDown')).toEqual({ row: 1, item: 0 });
  expect(from(2, 1)('ArrowDown')).toEqual({ row: 2, item: 1 });
  expect(from(0, 0)('ArrowUp')).toEqual({ row: 0, item: 0 });
  expect(from(0, 0)('ArrowRight')).toEqual({ row: 0, item: 1 });
  expect(from(1, 0)('ArrowRight')).toEqual({ row: 1, item: 0 });
  expect(from(1, 0)('End')).toEqual({ row: 2, item: 0 });
  expect(from(2, 1)('Home')).toEqual({ row: 0, item: 1 });
  expect(from(0, 0)('n')).toBeNull();
  expect(placeAfter('ArrowDown', { row: 0, item: 1 }, [4])).toEqual({ row: 0, item: 2 });
  expect(placeAfter('ArrowUp', { row: 0, item: 0 }, [4])).toEqual({ row: 0, item: 0 });
});
