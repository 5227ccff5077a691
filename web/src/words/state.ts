/** Signs of the states of tasks, so that states differ without colours; pure. */

/** The parts of a task that its sign depends on. */
export interface StatedTask {
  state: string;
  outcome: string | null;
}

const SIGNS: Record<string, string> = {
  pending: '○',
  enabled: '◇',
  ongoing: '●',
  interrupted: '▨',
};

const FAILURES = new Set(['failure', 'precondition failed', 'invariant violated']);

/** True for the word of each kind of failure: the parent of such a task fails unless a clause handles it. */
export function isFailure(outcome: string | null): boolean {
  return outcome !== null && FAILURES.has(outcome);
}

/** The sign of a task's state; `holdsInterrupted` is true if a task below it is interrupted. `·` for a task that does not exist yet. */
export function stateSign(task: StatedTask | undefined, holdsInterrupted = false): string {
  if (!task) return '·';
  if (task.state === 'ongoing' && holdsInterrupted) return '◐';
  if (task.state !== 'terminated') return SIGNS[task.state] ?? '·';
  if (isFailure(task.outcome)) return '▲';
  return task.outcome === null || task.outcome === 'success' ? '✓' : '–';
}
