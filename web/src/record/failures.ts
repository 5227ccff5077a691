/** Failures as alarms: one failure that the record has in several entries is one alarm. Pure. */

import type { Trouble } from './types';

/** The cause of a handled failure that began in a subtask, as the record states it. */
const OF_SUBTASK = /^its subtask T(\d+) failed/;
/** The goal that handles the failure, at the end of a message. */
const HANDLER = /; (\(.+\) handles it)$/;
/** The place of a program at the end of a message: `; from missions/diagnosis/mission.pdl:76:3`. */
const PLACE = /; from (\S+:\d+:\d+)$/;

/**
 * The entries with one entry for each failure. The failure of a task that the `on-failure` of a task above it handles is that of the task,
 * and the failure of the initial task is that of the flight. Faults have the place of the program as their cause instead of their subject
 * again.
 */
export function failures(troubles: readonly Trouble[]): Trouble[] {
  const together = (one: Trouble, other: Trouble) => one !== other && one.t_ns === other.t_ns;
  const failedTask = (entry: Trouble) => Number(OF_SUBTASK.exec(entry.cause)?.[1]);
  return troubles.flatMap(entry => {
    const around = troubles.filter(other => together(entry, other));
    if (entry.kind === 'fault') {
      if (around.some(other => other.kind === 'failed' && other.task === failedTask(entry))) return [];
      const place = PLACE.exec(entry.subject)?.[1];
      const subject = entry.subject.replace(PLACE, '');
      const repeats =
        HANDLER.test(subject) || subject.startsWith(entry.cause) || OF_SUBTASK.test(entry.cause);
      return [{ ...entry, subject, cause: repeats ? (place ? `at ${place}` : '') : entry.cause }];
    }
    if (entry.kind === 'failed') {
      if (entry.task === 0 && around.some(other => other.kind === 'ended')) return [];
      const handled = around.find(other => other.kind === 'fault' && failedTask(other) === entry.task);
      const handler = handled && HANDLER.exec(handled.subject)?.[1];
      return [handler ? { ...entry, cause: `${entry.cause}; ${handler}` } : entry];
    }
    const initial = around.find(other => other.kind === 'failed' && other.task === 0);
    if (entry.kind === 'ended' && initial)
      return [{ ...entry, cause: `${entry.cause}: ${initial.cause}`, task: entry.task ?? initial.task }];
    return [entry];
  });
}
