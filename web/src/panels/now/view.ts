/** The now line: the agent's present task, its cause, and the next task; pure. */

import type {
  Holdings,
  Mission,
  Observation,
  PlanInForce,
  Target,
  Task,
  TaskExplanation,
} from '../../record/types';
import { begunVisits } from '../../record/visits';
import { clock, plannedMinute } from '../../time/format';
import { shortValue, withDurations } from '../../words/duration';
import { brief, eventWords, type Names, untilTarget } from '../../words/phrase';

/** Longest cause that is shown. */
const CAUSE_MAX = 110;

/** The task that holds the flight path, or otherwise any resource, or otherwise the last ongoing task of the list. */
export function taskAtWork(holdings: Holdings | null, tasks: readonly Task[], atNs: number): number | null {
  const rows = holdings?.resources ?? [];
  const open = (row: (typeof rows)[number]) =>
    row.holdings.findLast(one => one.from_ns <= atNs && (one.open || one.to_ns > atNs))?.task;
  const ordered = [...rows].sort(
    (a, b) => Number(b.resource === 'flight-path') - Number(a.resource === 'flight-path'),
  );
  for (const row of ordered) {
    const task = open(row);
    if (task !== undefined) return task;
  }
  const ongoing = tasks.filter(task => task.state === 'ongoing');
  return ongoing.at(-1)?.id ?? null;
}

/** A cause of the explainer in one line. */
export function causeWords(cause: string, names: Names): string {
  const words = shortValue(withDurations(brief(cause, names)));
  return words.length > CAUSE_MAX ? `${words.slice(0, CAUSE_MAX - 1)}…` : words;
}

/** The tasks above a task, the nearest first. */
export function tasksAbove(tasks: readonly Task[], task: Pick<Task, 'parent'>): Task[] {
  const above: Task[] = [];
  for (let id = task.parent; id !== null; ) {
    const parent = tasks.find(one => one.id === id);
    if (!parent) break;
    above.push(parent);
    id = parent.parent;
  }
  return above;
}

/**
 * Why the task is at work. If the cause is only that its resources were granted, this is the condition that enabled it, or else the plan in
 * force that has the target of the task or of a task above it.
 */
export function reasonWords(
  answer: Pick<TaskExplanation, 'cause' | 'task' | 'explanation'>,
  plan: PlanInForce | null,
  names: Names,
  above: readonly Pick<Task, 'targets'>[] = [],
  goalOf: (task: number) => string | null = () => null,
): string {
  const history = answer.explanation?.history ?? [];
  const began = history.findLast(moment => moment.to === 'ongoing');
  if (began?.cause?.kind !== 'resources-granted') return causeWords(answer.cause, names);
  const enabled = history.findLast(moment => moment.to === 'enabled' && moment.id < began.id);
  if (enabled?.cause?.kind === 'preconditions-satisfied') {
    const evidence = evidenceWords(enabled.cause.evidence ?? [], names, goalOf);
    return evidence ?? causeWords(enabled.cause.observed, names);
  }
  const visit = [answer.task, ...above].flatMap(
    task => plan?.visits.find(one => task.targets.includes(one.target)) ?? [],
  )[0];
  if (!plan || !visit) return causeWords(answer.cause, names);
  const adopted = clock(plan.adopted_ns / 1e9);
  return `plan ${plan.number}, adopted ${adopted}, has ${names.get(visit.target) ?? visit.target}`;
}

/** `power up camera 1 ended at 0:53:04`: the last one of ended tasks and messages, without numbers of tasks; null for other evidence. */
function evidenceWords(
  evidence: readonly Observation[],
  names: Names,
  goalOf: (task: number) => string | null,
): string | null {
  const events = evidence.flatMap(one => (one.type === 'task-end' || one.type === 'event' ? [one] : []));
  const last = events.reduce<(typeof events)[number] | null>(
    (best, one) => (best === null || one.at > best.at ? one : best),
    null,
  );
  if (!last || events.length < evidence.length) return null;
  if (last.type === 'event') return `${eventWords(last.form, names)} at ${clock(last.at)}`;
  const goal = goalOf(last.task_number);
  return `${goal === null ? 'the step before it' : untilTarget(goal, names)} ended at ${clock(last.at)}`;
}

/** The visit of the plan in force after the last one begun, also if it is late: `East Zone Complex, planned 9:35`. */
export function nextWords(plan: PlanInForce | null, targets: readonly Target[], atNs: number): string {
  if (!plan) return '';
  const begun = begunVisits(plan, targets, atNs);
  const visit = plan.visits[begun.findLastIndex(one => one !== null) + 1];
  if (!visit) return '';
  const target = targets.find(one => one.id === visit.target || one.name === visit.target);
  return `${target?.name ?? visit.target}, planned ${plannedMinute(visit.begin_ns)}`;
}

/** How a flight that is over ended. */
export function endWords(mission: Mission | null): { words: string; failed: boolean } | null {
  const ending = mission?.ending;
  return ending
    ? { words: ending.failed ? `▲ failed: ${ending.reason}` : ending.reason, failed: ending.failed }
    : null;
}

/** What the task does; where its goal names no target, also the task above that does: `hover, to visit School`. */
export function whatWords(
  task: Pick<Task, 'goal' | 'targets'>,
  names: Names,
  above: readonly Pick<Task, 'goal' | 'targets'>[] = [],
): string {
  const hasTarget = ({ targets }: Pick<Task, 'targets'>) => targets.length > 0;
  const own = untilTarget(task.goal, names);
  const purpose = hasTarget(task) ? undefined : above.find(hasTarget);
  return purpose ? `${own}, to ${untilTarget(purpose.goal, names)}` : own;
}
