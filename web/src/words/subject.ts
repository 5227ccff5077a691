/** Subjects of timeline entries as phrases. Pure. */

import { type Names, phrase } from './phrase';

/** A goal as a phrase, a target by its name, a message unchanged. */
export function subjectWords(subject: string, names: Names): string {
  return subject.startsWith('(') ? phrase(subject, names) : (names.get(subject) ?? subject);
}

/** `roll angle`, for `(roll-angle aircraft-1)`. */
export function signalWords(attribute: string): string {
  return attribute.replaceAll('-', ' ');
}
