/** Texts of the questions that wait for an answer; pure. */

import type { AskedQuestion } from '../../record/types';
import { missionTime, NANOSECONDS_PER_SECOND, span } from '../../time/format';

/** The questions that are open at an instant, oldest first. */
export function openAt(questions: readonly AskedQuestion[], atNs: number): AskedQuestion[] {
  return questions.filter(
    asked => asked.asked_ns <= atNs && (asked.closed_ns === null || asked.closed_ns > atNs),
  );
}

/** What happens without an answer: `at T+0:29:30, in 1 min 12 s, fire is taken`. */
export function deadline(asked: AskedQuestion, atNs: number): string {
  if (asked.by_ns === null) return 'no deadline';
  const without = asked.default === null ? 'its task fails' : `${asked.default} is taken`;
  const left = asked.by_ns - atNs;
  const wait = left < NANOSECONDS_PER_SECOND ? 'now' : `in ${span(left)}`;
  return `at ${missionTime(asked.by_ns)}, ${wait}, ${without}`;
}
