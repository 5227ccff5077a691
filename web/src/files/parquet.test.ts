import { parquetReadObjects } from 'hyparquet';
import { expect, it } from 'vitest';
import { parquet } from './parquet';

it('writes a file that another reader reads', async () => {
  const file = await parquet([
    { name: 'signal', type: 'STRING', data: ['(a b)', '(c "d")'] },
    { name: 'time_s', type: 'DOUBLE', data: [0.1, 33_432.25] },
    { name: 'value', type: 'DOUBLE', data: [-1e-9, null] },
    { name: 'samples', type: 'INT32', data: [1, 7] },
  ]);
  expect(await parquetReadObjects({ file })).toEqual([
    { signal: '(a b)', time_s: 0.1, value: -1e-9, samples: 1 },
    { signal: '(c "d")', time_s: 33_432.25, value: null, samples: 7 },
  ]);
});
