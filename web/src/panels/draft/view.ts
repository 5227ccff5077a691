/** A drawn plan: the order of visits and the messages that commit it; pure. */

import type { PlanInForce, Target } from '../../record/types';
import { begunVisits, isGone } from '../../record/visits';
import { NANOSECONDS_PER_SECOND, plannedClock } from '../../time/format';

/** The part of a plan that is still to be flown. */
export interface OpenPart {
  /** Identifiers of the targets in the order of the visits. */
  visits: string[];
  /** The target of the first visit, if the vehicle observes it or is on the way to it later than planned. */
  underWay: string | null;
  /** Planned visits that were not flown although later ones have begun. */
  missed: { target: string; beginNs: number }[];
}

/** The visits of a plan that are not over. A visit whose planned begin is past is open until it, or a later one, has been flown. */
export function openPart(plan: PlanInForce | null, targets: readonly Target[], atNs: number): OpenPart {
  const idOf = (name: string) => targets.find(one => one.id === name || one.name === name)?.id ?? name;
  const planned = (plan?.visits ?? []).map(visit => ({ ...visit, target: idOf(visit.target) }));
  const begun = plan ? begunVisits({ ...plan, visits: planned }, targets, atNs) : [];
  const last = begun.findLastIndex(begin => begin !== null);
  const isObserved = (index: number) =>
    index === last && targets.find(one => one.id === planned[index]?.target)?.state === 'observing';
  const open = planned.filter((_, index) => index > last || isObserved(index));
  const first = open[0];
  const isUnderWay = first !== undefined && (first.begin_ns <= atNs || isObserved(planned.indexOf(first)));
  return {
    visits: open.map(visit => visit.target),
    underWay: isUnderWay ? first.target : null,
    missed: planned
      .filter((_, index) => index < last && begun[index] === null)
      .map(visit => ({ target: visit.target, beginNs: visit.begin_ns })),
  };
}

/** What the draft does to the visit under way; null without one. `nameOf` gives the name of a target. */
export function underWayWords(
  underWay: string | null,
  draft: readonly string[],
  nameOf: (target: string) => string,
): { words: string; isLost: boolean } | null {
  if (underWay === null) return null;
  const name = nameOf(underWay);
  if (draft[0] === underWay)
    return { words: `The visit of ${name} is under way; it stays the first.`, isLost: false };
  const what = draft.includes(underWay) ? 'is not the first visit of this draft' : 'is not in this draft';
  return {
    words: `The visit of ${name} is under way and ${what}: the vehicle would turn away from it.`,
    isLost: true,
  };
}

/** `Not flown, and not in the draft: Winery, planned 0:12:40.`; empty if none was missed. */
export function missedWords(missed: OpenPart['missed'], nameOf: (target: string) => string): string {
  if (missed.length === 0) return '';
  const each = missed.map(({ target, beginNs }) => `${nameOf(target)}, planned ${plannedClock(beginNs)}`);
  return `Not flown, and not in the draft: ${each.join('; ')}.`;
}

/** `visits` with the visit at `from` moved to another position. */
export function movedVisit(visits: readonly string[], from: number, by: 1 | -1): string[] {
  const list = [...visits];
  const [visit] = list.splice(from, 1);
  if (visit !== undefined) list.splice(Math.min(Math.max(from + by, 0), list.length), 0, visit);
  return list;
}

/** `visits` without the one at `index`; other visits of the same target stay. */
export function withoutVisit(visits: readonly string[], index: number): string[] {
  return visits.filter((_, at) => at !== index);
}

/** The messages that make the flight plan exactly these visits, in this order. */
export function commitForms(visits: readonly string[]): string[] {
  return [`(plan-imposed (${visits.join(' ')}))`, '(off-schedule imposed-plan)'];
}

/** Targets that can still be visited and are not in the draft. */
export function addable(targets: readonly Target[], visits: readonly string[]): Target[] {
  return targets.filter(
    target => target.state !== 'observed' && !isGone(target) && !visits.includes(target.id),
  );
}

/** The draft as a table: visits, with the times of the validated plan if there is one. */
export function draftTable(
  visits: readonly string[],
  plan: PlanInForce | null,
): (string | number | null)[][] {
  const rows = visits.map((target, index) => {
    const visit = plan?.visits[index];
    const times = visit
      ? [visit.begin_ns, visit.end_ns].map(ns => ns / NANOSECONDS_PER_SECOND)
      : [null, null];
    return [index + 1, target, ...times];
  });
  return [['visit', 'target', 'begin_s', 'end_s'], ...rows];
}
