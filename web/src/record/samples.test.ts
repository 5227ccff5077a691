import { expect, it } from 'vitest';
import { allSamples } from './samples';
import type { SamplesQuery } from './source';
import type { SignalWindow, SignalWindows } from './types';

/** A server with a sample each second, whose answers have at most five entries, and the sample before the window. */
function server(count: number, words: string[] = []): (query: SamplesQuery) => Promise<SignalWindows> {
  return async ({ fromNs, toNs }) => {
    const times = Array.from({ length: count }, (_, index) => index * 1e9);
    const inside = times.filter(time => time >= fromNs && time <= toNs);
    const before = times.findLast(time => time < fromNs);
    const size = inside.length > 5 ? 3 : 1;
    const entries = inside.filter((_, index) => index % size === 0);
    const t_ns = [...(before === undefined ? [] : [before]), ...entries];
    const value = t_ns.map(time => time / 1e9);
    const window = {
      name: 'x',
      kind: words.length > 0 ? 'words' : 'number',
      words,
      t_ns,
      low: value,
      high: value,
      mean: value,
      count: t_ns.map(time => (inside.includes(time) ? size : 1)),
    } as unknown as SignalWindow;
    return { windows: [window] } as SignalWindows;
  };
}

it('reads each sample once, in as many parts as needed', async () => {
  const query = { names: ['x'], fromNs: 0, toNs: 40e9, atNs: 40e9 };
  const { windows, complete } = await allSamples(server(41), query, 1000);
  expect(complete).toBe(true);
  expect(windows[0]?.mean).toEqual(Array.from({ length: 41 }, (_, index) => index));
  const cut = await allSamples(server(41), query, 10);
  expect(cut.complete).toBe(false);
});
