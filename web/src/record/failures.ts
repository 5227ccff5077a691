/** Failures as alarms: one failure that the record has in several entries is one alarm. Pure. */

import type { Trouble } from './types';

/**
 * The entries with one entry for each failure. The failure of a task that the `on-failure` of a task above it handles is that of the task,
 * and the failure of the initial task is that of the flight. Faults have the place of the program as their cause instead of their subject
 * again.
 */
export function failures(troubles: readonly Trouble[]): Trouble[] {
  const together = (one: Trouble, other: Trouble) => one !== other && one.t_ns === other.t_ns;
  return troubles.flatMap(entry => {
    const around = troubles.filter(other => together(entry, other));
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
