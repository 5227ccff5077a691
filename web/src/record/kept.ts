/** Keeps what is equal to what was shown before, so that only the parts of the page are drawn again that have changed. Pure. */

import type { Target } from './types';

/** True for equal values of JSON: lists and objects with equal members, equal numbers, texts and truth values. */
export function isEqual(one: unknown, other: unknown): boolean {
  if (Object.is(one, other)) return true;
  if (typeof one !== 'object' || typeof other !== 'object' || one === null || other === null) return false;
  if (Array.isArray(one) !== Array.isArray(other)) return false;
  const [members, others] = [one as Record<string, unknown>, other as Record<string, unknown>];
  const names = Object.keys(members);
  if (names.length !== Object.keys(others).length) return false;
  return names.every(name => name in others && isEqual(members[name], others[name]));
}

/** The rows of `after`; those that equal the row before with the same identifier are the same objects as before. */
export function keptRows<T extends { id: string }>(before: readonly T[], after: readonly T[]): T[] {
  const known = new Map(before.map(row => [row.id, row]));
  return after.map(row => {
    const old = known.get(row.id);
    return old && isEqual(old, row) ? old : row;
  });
}

/** The names of the targets by identifier; the names before, if they are equal. */
export function keptNames(
  before: ReadonlyMap<string, string>,
  targets: readonly Pick<Target, 'id' | 'name'>[],
): ReadonlyMap<string, string> {
  const names = new Map(targets.map(target => [target.id, target.name]));
  const isKept = names.size === before.size && [...names].every(([id, name]) => before.get(id) === name);
  return isKept ? before : names;
}
