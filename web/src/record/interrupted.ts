/** Visits that ended by an interruption: records state when a visit begins and what it has as result, but not that it was left; pure. */

import type { Ending, Target, Task, Trouble } from './types';

/** The state of a target whose visit was interrupted, in its history. */
export const INTERRUPTED = 'interrupted';

/** The last interruption of a task whose goal names the target, since its visit under way began; null without one. */
export function interruptionOf(target: Target, troubles: readonly Trouble[]): Trouble | null {
  const began = target.history.findLast(change => change.state === 'observing');
  if (target.state !== 'observing' || !began) return null;
  return (
    troubles.findLast(
      one => one.kind === 'interrupted' && one.t_ns >= began.t_ns && one.targets.includes(target.id),
    ) ?? null
  );
}

/**
 * The targets without visits that are no longer under way: those whose task is still interrupted, and after the end of the flight all. An
 * interrupted task may resume. `tasks` are those that have not ended, at the same instant.
 */
export function withEndedVisits(
  targets: Target[],
  troubles: readonly Trouble[],
  tasks: readonly Pick<Task, 'id' | 'state'>[],
  ending: Ending | null,
  endNs: number,
): Target[] {
  const changed = targets.map(target => {
    if (target.state !== 'observing') return target;
    const interruption = interruptionOf(target, troubles);
    const task = interruption && tasks.find(one => one.id === interruption.task);
    if (ending === null && task?.state !== 'interrupted') return target;
    const change = {
      t_ns: interruption?.t_ns ?? endNs,
      state: INTERRUPTED,
      detail: 'the visit was interrupted',
    };
    const { state, detail, t_ns } = change;
    return { ...target, state, detail, since_ns: t_ns, history: [...target.history, change] };
  });
  // The same list while no visit has ended: what is drawn from it needs no new drawing.
  return changed.every((target, index) => target === targets[index]) ? targets : changed;
}
