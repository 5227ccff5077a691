/** Texts of the operator bar; pure. */

import type { SentCommand } from '../../player/operator.svelte';
import { VALID_MS } from '../../record/operation';
import type { CommandState, OpenQuestion, Operation, Wish } from '../../record/types';
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

/** A command in the words of the record. */
export function wishWords(wish: Wish): string {
  switch (wish.do) {
    case 'pace':
      return wish.pace === null ? 'pace as fast as possible' : `pace ${wish.pace}`;
    case 'answer':
      return `answer ${wish.question} of ${wish.agent}: ${wish.answer}`;
    case 'message':
      return `message: ${wish.form}`;
    case 'value-target':
      return `value of target ${wish.target}: ${wish.value}`;
    case 'acknowledge':
      return `acknowledge ${wish.alarm}`;
    case 'offer-authority':
      return `offer authority to ${wish.to}`;
    case 'add-target':
    case 'remove-target':
      return `${wish.do.replace('-', ' ')} ${wish.target}`;
    default:
      return wish.do.replace('-', ' ');
  }
}

/** The commands that the server has neither answered nor listed, which is silent then. */
export function unheard(
  sent: readonly SentCommand[],
  operation: Pick<Operation, 'commands' | 'authority'>,
): SentCommand[] {
  const first = sent[0];
  if (!first) return [];
  const { name } = operation.authority.you;
  const listed = operation.commands.filter(one => one.by === name && one.number > first.after).length;
  return sent.slice(listed);
}

/** `pause: sent 3.0 s`; after ten seconds that it has expired. */
export function sentText(
  { wish, sentMs }: SentCommand,
  nowMs: number,
): { words: string; state: CommandState['state'] } {
  const age = Math.max(0, nowMs - sentMs);
  const words = wishWords(wish);
  if (age < VALID_MS) return { words: `${words}: sent ${(age / 1000).toFixed(1)} s`, state: 'sent' };
  const late = 'the server does not answer; a command that it has not begun is no longer carried out';
  return { words: `${words}: expired after 10 s: ${late}`, state: 'expired' };
}

/** The fault of a typed value of a target; null for a number that is not negative. */
export function valueFault(text: string): string | null {
  if (/^\d+(\.\d+)?$/.test(text.trim())) return null;
  return text.trim() === ''
    ? 'type a value first'
    : `${text.trim()} is not a value: expected a number of 0 or more`;
}
