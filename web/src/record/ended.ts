/** Targets at an instant without visits that are no longer under way. */

import { interruptionOf, withEndedVisits } from './interrupted';
import type { RecordSource } from './source';
import type { Mission, Target, Trouble } from './types';

/** Requests tasks only if a visit under way was interrupted, because its task may have resumed. */
export async function targetsWithoutEndedVisits(
  source: Pick<RecordSource, 'tasks'>,
  targets: Target[],
  troubles: readonly Trouble[],
  { ending, end_ns }: Pick<Mission, 'ending' | 'end_ns'>,
  atNs: number,
): Promise<Target[]> {
  const isUnsure = ending === null && targets.some(target => interruptionOf(target, troubles) !== null);
  const tasks = isUnsure ? (await source.tasks({ atNs, ended: false, find: '', with: null })).tasks : [];
  return withEndedVisits(targets, troubles, tasks, ending, Math.min(end_ns, atNs));
}
