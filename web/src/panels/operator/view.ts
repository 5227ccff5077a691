/** Texts of the operator bar; pure. */

import type { CommandState, OpenQuestion, Operation } from '../../record/types';
import { NANOSECONDS_PER_SECOND, span } from '../../time/format';

/** The paces to choose from; null is as fast as possible. */
export const PACES: (number | null)[] = [1, 2, 5, 10, 30, 60, 120, 300, 1000, null];

/** `60× real time`. */
export function paceText(pace: number | null): string {
  if (pace === null) return 'as fast as possible';
  return pace === 1 ? 'real time' : `${pace}× real time`;
}

/** Texts such as `running, 60× real time`, `paused`, `planning (visit ..) for 2.1 s; mission time stands still`. */
export function runText(operation: Operation): string {
  const { planning, paused, pace } = operation;
  if (planning)
    return `planning ${planning.goal} for ${planning.since_s.toFixed(1)} s; mission time stands still`;
  return paused ? 'paused' : `running, ${paceText(pace)}`;
}

/** `accepted`, `rejected: question 3 is not open`, `sent 0.4 s`. */
export function endText(command: CommandState): string {
  if (command.state === 'sent') return `sent ${command.age_s.toFixed(1)} s`;
  return command.reason ? `${command.state}: ${command.reason}` : command.state;
}

/** The deadline of a question: `fire is taken in 1 min 12 s`. */
export function deadlineText(question: OpenQuestion, nowNs: number): string {
  const without = question.default === null ? 'its task fails' : `${question.default} is taken`;
  if (question.by_ns === null) return 'no deadline';
  const left = Math.max(0, question.by_ns - nowNs);
  return left < NANOSECONDS_PER_SECOND ? `${without} now` : `${without} in ${span(left)}`;
}

/**
 * The last command of this station, and the last command of another one if that is newer: it must not look like the end of the own
 * command.
 */
export function lastCommands(operation: Pick<Operation, 'commands' | 'authority'>): CommandState[] {
  const isOwn = (command: CommandState) => command.by === operation.authority.you.name;
  const own = operation.commands.findLast(isOwn);
  const other = operation.commands.findLast(command => !isOwn(command));
  if (!other || (own && own.number > other.number)) return own ? [own] : [];
  return own ? [own, other] : [other];
}

/** `pause: accepted`; of another station `pause by ann: accepted`. */
export function commandText(command: CommandState, ownName: string): string {
  const by = command.by === ownName ? '' : ` by ${command.by}`;
  return `${command.words}${by}: ${endText(command)}`;
}
