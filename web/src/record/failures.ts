/** Failures as alarms: one failure that the record has in several entries is one alarm. Pure. */

import type { Trouble } from './types';

/**
 * The entries with one entry for each failure. The failure of a task that the `on-failure` of a task above it handles is that of the task,
 * and the failure of the initial task is that of the flight. Faults have the place of the program as their cause instead of their subject
 * again.
 */
export function failures(troubles: readonly Trouble[]): Trouble[] {
  // Hundreds of targets can be left out at one instant: each entry is a separate alarm.
  const isAlone = ({ kind }: Trouble) => kind === 'left-out' || kind === 'interrupted';
  const together = new Map<number, Trouble[]>();
  for (const entry of troubles) {
    if (isAlone(entry)) continue;
    const same = together.get(entry.t_ns);
    if (same) same.push(entry);
    else together.set(entry.t_ns, [entry]);
  }
  return troubles.flatMap(entry => {
    if (isAlone(entry)) return [entry];
    const around = together.get(entry.t_ns) ?? [];
    if (entry.kind === 'fault') {
      const { failed_child, handler, place } = entry;
      const isOfChild = (other: Trouble) => other.kind === 'failed' && other.task === failed_child;
      if (failed_child !== null && around.some(isOfChild)) return [];
      // The message of a handled failure has its cause.
      const repeats = handler !== null || failed_child !== null || entry.cause === '';
      return [{ ...entry, cause: repeats ? (place === null ? '' : `at ${place}`) : entry.cause }];
    }
    if (entry.kind === 'failed') {
      if (entry.task === 0 && around.some(other => other.kind === 'ended')) return [];
      const isHandled = (other: Trouble) => other.kind === 'fault' && other.failed_child === entry.task;
      const handler = entry.task === null ? null : around.find(isHandled)?.handler;
      return [handler ? { ...entry, cause: `${entry.cause}; ${handler} handles it` } : entry];
    }
    const initial = around.find(other => other.kind === 'failed' && other.task === 0);
    if (entry.kind === 'ended' && initial)
      return [{ ...entry, cause: `${entry.cause}: ${initial.cause}`, task: entry.task ?? initial.task }];
    return [entry];
  });
}
