/** Failures as alarms: one failure that the record has in several entries is one alarm. Pure. */

import type { Trouble } from './types';

/** A task whose failure no other task handles, as the record states it. */
const UNHANDLED = /^its subtask T(\d+) failed and nothing handles that/;
/** The place of a program at the end of a message: `; from missions/diagnosis/mission.pdl:76:3`. */
const PLACE = /; from (\S+:\d+:\d+)$/;

/**
 * The entries with one entry for each failure. The failure of a task that no other task handles is that of the task, and the failure of
 * the initial task is that of the flight. Faults have the place of the program as their cause instead of their subject again.
 */
export function failures(troubles: readonly Trouble[]): Trouble[] {
  const together = (one: Trouble, other: Trouble) => one !== other && one.t_ns === other.t_ns;
  return troubles.flatMap(entry => {
    const around = troubles.filter(other => together(entry, other));
    if (entry.kind === 'fault') {
      const unhandled = UNHANDLED.exec(entry.subject);
      const task = Number(unhandled?.[1]);
      if (around.some(other => other.kind === 'failed' && other.task === task)) return [];
      const place = PLACE.exec(entry.subject)?.[1];
      const subject = unhandled
        ? 'a subtask failed and nothing handles that'
        : entry.subject.replace(PLACE, '');
      const repeats = entry.subject.startsWith(entry.cause);
      return [{ ...entry, subject, cause: repeats ? (place ? `at ${place}` : '') : entry.cause }];
    }
    if (entry.kind === 'failed') {
      if (entry.task === 0 && around.some(other => other.kind === 'ended')) return [];
      const isUnhandled = around.some(
        other => other.kind === 'fault' && Number(UNHANDLED.exec(other.subject)?.[1]) === entry.task,
      );
      return [isUnhandled ? { ...entry, cause: `${entry.cause}; nothing handles this failure` } : entry];
    }
    const initial = around.find(other => other.kind === 'failed' && other.task === 0);
    if (entry.kind === 'ended' && initial)
      return [{ ...entry, cause: `${entry.cause}: ${initial.cause}`, task: entry.task ?? initial.task }];
    return [entry];
  });
}
