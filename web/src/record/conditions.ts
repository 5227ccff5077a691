/** Whether watched conditions hold. Pure. */

import type { MonitoredCondition } from './types';

/** Kinds of conditions that are about measured values. */
const MEASURED = new Set(['measurement', 'episode']);

/** True or false as the data decide; null if they do not: a condition on a variable without a sample is not known to be false. */
export function holdsOf(condition: MonitoredCondition): boolean | null {
  if (condition.holds !== false) return condition.holds;
  if (MEASURED.has(condition.kind) && condition.value === null) return null;
  const parts = condition.parts.map(holdsOf);
  const open = parts.includes(null);
  switch (condition.kind) {
    case 'and':
      return open && !parts.includes(false) ? null : false;
    case 'or':
    case 'in-order':
    case 'not':
      return open ? null : false;
    default:
      return false;
  }
}
