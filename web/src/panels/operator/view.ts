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
