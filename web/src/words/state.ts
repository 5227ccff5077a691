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

/** The sign of a task's state; `holdsInterrupted` is true if a task below it is interrupted. `·` for a task that does not exist yet. */
export function stateSign(task: StatedTask | undefined, holdsInterrupted = false): string {
  if (!task) return '·';
  if (task.state === 'ongoing' && holdsInterrupted) return '◐';
  if (task.state !== 'terminated') return SIGNS[task.state] ?? '·';
  const outcome = (task.outcome ?? '').toLowerCase();
  return outcome.startsWith('fail') ? '▲' : outcome.startsWith('cut') ? '–' : '✓';
}
