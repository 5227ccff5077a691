/** All samples of signals: the server draws windows with many samples at a resolution, so that they are read in parts. */

import type { SamplesQuery } from './source';
import type { SignalWindow, SignalWindows } from './types';

/** Resolution of each part, the server's greatest. */
const PIXELS = 8000;
/** Parts shorter than this are not divided, in nanoseconds. */
const SHORTEST_NS = 1e9;

/** True if each entry is a sample; a word holds until the next entry. */
function isComplete(window: SignalWindow): boolean {
  return window.kind === 'words' || window.count.every(count => count === 1);
}

/**
 * The samples of a window of time, each in its own entry. `complete` is false once more than `samplesMax` entries were read: the rest is at
 * the server's resolution.
 */
export async function allSamples(
  ask: (query: SamplesQuery) => Promise<SignalWindows>,
  query: Omit<SamplesQuery, 'pixels'>,
  samplesMax: number,
): Promise<{ windows: SignalWindow[]; complete: boolean }> {
  const windows = new Map<string, SignalWindow>();
  let [count, complete] = [0, true];
  const read = async (fromNs: number, toNs: number): Promise<void> => {
    const answer = await ask({ ...query, fromNs, toNs, pixels: PIXELS });
    const isExact = answer.windows.every(isComplete);
    if (!isExact && toNs - fromNs > SHORTEST_NS && count < samplesMax) {
      const middle = Math.floor((fromNs + toNs) / 2);
      await read(fromNs, middle);
      await read(middle + 1, toNs);
      return;
    }
    complete &&= isExact;
    for (const window of answer.windows) {
      const found = joined(windows.get(window.name), window, fromNs, toNs);
      windows.set(window.name, found);
      count += window.t_ns.length;
    }
  };
  await read(query.fromNs, query.toNs);
  return { windows: query.names.flatMap(name => windows.get(name) ?? []), complete };
}

/** The entries of two parts; an answer also has the last sample before its part. */
function joined(
  before: SignalWindow | undefined,
  part: SignalWindow,
  fromNs: number,
  toNs: number,
): SignalWindow {
  const inside = part.t_ns
    .map((time, index) => ({ time, index }))
    .filter(({ time }) => time >= fromNs && time <= toNs);
  const pick = (column: readonly number[]) => inside.map(({ index }) => column[index] ?? 0);
  // The words of each part have their own numbers.
  const words = [...new Set([...(before?.words ?? []), ...part.words])];
  const renumber = (column: readonly number[]) =>
    part.kind === 'words'
      ? pick(column).map(number => words.indexOf(part.words[number] ?? ''))
      : pick(column);
  return {
    ...part,
    words,
    t_ns: [...(before?.t_ns ?? []), ...inside.map(({ time }) => time)],
    low: [...(before?.low ?? []), ...renumber(part.low)],
    high: [...(before?.high ?? []), ...renumber(part.high)],
    mean: [...(before?.mean ?? []), ...renumber(part.mean)],
    count: [...(before?.count ?? []), ...pick(part.count)],
  };
}
