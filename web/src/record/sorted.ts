/** Searches in sorted times; pure. */

/** Number of entries in the sorted `times` that are not after `at`. */
export function countUntil(times: readonly number[], at: number): number {
  return countWhile(times, time => time <= at);
}

/** Number of entries in the sorted `times` that are before `at`. */
export function countBefore(times: readonly number[], at: number): number {
  return countWhile(times, time => time < at);
}

function countWhile(times: readonly number[], isCounted: (time: number) => boolean): number {
  let [low, high] = [0, times.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (isCounted(times[middle] as number)) low = middle + 1;
    else high = middle;
  }
  return low;
}
