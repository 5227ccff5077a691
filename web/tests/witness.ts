/**
 * A second account of a flight: what `apex trace` prints up to an instant, folded by code that shares nothing with the server and the
 * page. Pages of random instants are compared with it.
 */

import { execFileSync } from 'node:child_process';
import { apexProgram } from './server';

/** A line of `apex trace --json`. */
interface Line {
  t: number;
  kind: string;
  task?: string;
  goal?: string;
  parent?: string;
  from?: string;
  state?: string;
  outcome?: string;
  cause?: string;
  form?: string;
  summary?: string;
  question?: number;
  text?: string;
  message?: string;
}

/** A task according to the trace. */
export interface WitnessTask {
  goal: string;
  parent: string | null;
  state: string;
  outcome: string | null;
  /** Resources that it was granted when it became ongoing. */
  holds: string[];
}

/** The state of a flight according to the trace, up to an instant. */
export interface Witness {
  tasks: Map<string, WitnessTask>;
  /** Summaries of the adopted plans, the first one first. */
  plans: string[];
  /** Texts of the questions that wait for an answer, by number. */
  questions: Map<number, { task: string; text: string }>;
  /** Number of questions so far. */
  asked: number;
  /** Number of tasks that failed, and of faults. */
  failures: number;
  faults: number;
  /** Targets that messages have announced. */
  announced: Set<string>;
  /** Targets that messages have reported as observed. */
  observed: Set<string>;
  /** Resources that any task has held. */
  resources: Set<string>;
}

const KINDS = 'created,transition,selected,plan,ask,withdraw-question,trouble,event'; // english: allow

/** All lines of some kinds in a record: by default those that the witness reads. */
export function traceOf(record: string, kinds = KINDS): Line[] {
  const text = execFileSync(apexProgram(), ['trace', record, '--json', '--type', kinds], {
    maxBuffer: 1 << 29,
    stdio: ['ignore', 'pipe', 'ignore'],
  });
  return text
    .toString()
    .trim()
    .split('\n')
    .map(line => JSON.parse(line));
}

/** Folds the lines up to an instant. */
export function witnessAt(lines: readonly Line[], atS: number): Witness {
  const seen: Witness = {
    tasks: new Map(),
    plans: [],
    questions: new Map(),
    asked: 0,
    failures: 0,
    faults: 0,
    announced: new Set(),
    observed: new Set(),
    resources: new Set(),
  };
  for (const line of lines) {
    if (line.t > atS) break;
    take(seen, line);
  }
  return seen;
}

function take(seen: Witness, line: Line): void {
  const { task = '', goal = '' } = line;
  const known = seen.tasks.get(task);
  switch (line.kind) {
    case 'created':
      seen.tasks.set(task, { goal, parent: line.parent ?? null, state: 'pending', outcome: null, holds: [] });
      break;
    case 'selected':
      if (known) known.goal = goal;
      break;
    case 'transition':
      if (known) change(seen, task, known, line);
      break;
    case 'plan':
      seen.plans.push(line.summary ?? '');
      break;
    case 'ask':
      seen.asked += 1;
      seen.questions.set(line.question ?? -1, { task, text: line.text ?? '' });
      break;
    case 'withdraw-question':
      seen.questions.delete(line.question ?? -1);
      break;
    case 'trouble': // english: allow
      // The failure of a task that a task above it handles is that of the task: one failure is one alarm.
      if (!/^its subtask T\d+ failed/.test(line.cause ?? '')) seen.faults += 1;
      break;
    default:
      hear(seen, line.form ?? '');
  }
}

function change(seen: Witness, task: string, known: WitnessTask, line: Line): void {
  known.state = line.state ?? '';
  known.outcome = line.outcome ?? null;
  const granted = /^it was granted (.+)$/.exec(line.cause ?? '')?.[1];
  known.holds = line.state === 'ongoing' && granted ? granted.split(/, | and /) : [];
  for (const resource of known.holds) seen.resources.add(resource);
  if (/fail|violated/.test(line.outcome ?? '')) seen.failures += 1;
  if (line.state === 'terminated')
    for (const [number, asked] of seen.questions) if (asked.task === task) seen.questions.delete(number);
}

function hear(seen: Witness, form: string): void {
  const [, head, target] = /^\(([a-z-]+) ([^ ()/]+)/i.exec(form) ?? [];
  if (head === 'new-target' && target) seen.announced.add(target);
  if (head === 'observed' && target) seen.observed.add(target);
}

/** A generator of numbers from 0 to below 1: xorshift (Marsaglia 2003). */
export function numbers(seed: number): () => number {
  let state = seed >>> 0 || 1;
  return () => {
    state ^= state << 13;
    state ^= state >>> 17;
    state ^= state << 5;
    state >>>= 0;
    return state / 2 ** 32;
  };
}
