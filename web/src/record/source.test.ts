import { afterEach, expect, it, vi } from 'vitest';
import { ServedRecord } from './source';

afterEach(() => vi.unstubAllGlobals());

it('equal requests made at once share one answer, and later ones are sent again', async () => {
  const asked: string[] = [];
  vi.stubGlobal('fetch', async (address: string) => {
    const number = asked.push(address);
    return { ok: true, text: async () => JSON.stringify({ number }) };
  });
  const record = new ServedRecord('http://server');
  const [first, second, other] = await Promise.all([record.report(5), record.report(5), record.report(6)]);
  expect(second).toEqual(first);
  expect(other).not.toEqual(first);
  expect(asked).toEqual(['http://server/api/report?at=5', 'http://server/api/report?at=6']);
  await record.report(5);
  expect(asked).toHaveLength(3);
});
