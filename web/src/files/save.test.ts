import { expect, it } from 'vitest';
import { csv } from './save';

it('quotes what would break a row', () => {
  expect(
    csv([
      ['t', 'text'],
      [1.5, 'a, "b"\nc'],
      [null, ''],
    ]),
  ).toBe('t,text\r\n1.5,"a, ""b""\nc"\r\n,\r\n');
});
