import { expect, it } from 'vitest';
import { interruptionOf, withEndedVisits } from './interrupted';
import type { Target, Trouble } from './types';
import { shownState, visitsOf } from './visits';

const change = (t_ns: number, state: string) => ({ t_ns, state, detail: null });
const yard = {
  id: 'yard',
  name: 'Yard',
  state: 'observing',
  detail: null,
  gone_ns: null,
  observed_ns: 20,
  history: [change(10, 'observing'), change(20, 'observed'), change(30, 'observing')],
} as unknown as Target;
const interrupted = (t_ns: number, targets: string[], subject = '(visit)'): Trouble => ({
  t_ns,
  kind: 'interrupted',
  subject,
  cause: '',
  task: 7,
  failed_child: null,
  handler_task: null,
  handler: null,
  place: null,
  target: null,
  targets,
  cause_kind: 'outranked',
});
const troubles = [interrupted(40, ['yard']), interrupted(50, ['barn'])];
const ending = { reason: 'done', failed: false };

it('a visit ends with the interruption of its task, while the task is interrupted', () => {
  const [left] = withEndedVisits([yard], troubles, [{ id: 7, state: 'interrupted' }], null, 60);
  expect(left && shownState(left)).toBe('observed');
  expect(visitsOf(left ? [left] : [], 60).at(-1)).toMatchObject({ toNs: 40, state: 'interrupted' });
  const [resumed] = withEndedVisits([yard], troubles, [{ id: 7, state: 'ongoing' }], null, 60);
  expect(resumed).toBe(yard);
});

it('no visit is under way after the end of the flight', () => {
  const [left] = withEndedVisits([yard], troubles, [], ending, 60);
  expect(visitsOf(left ? [left] : [], 90).at(-1)).toMatchObject({ fromNs: 30, toNs: 40 });
  const [late] = withEndedVisits([{ ...yard, observed_ns: null }], [], [], ending, 60);
  expect(late && shownState(late)).toBe('known');
  expect(visitsOf(late ? [late] : [], 90).at(-1)).toMatchObject({ fromNs: 30, toNs: 60 });
});

it('an interruption before the visit, or of another target, is none of it', () => {
  // The words of a goal count for nothing: a message may quote the name.
  const quoting = interrupted(45, [], '(print "visit yard now")');
  expect(interruptionOf(yard, [interrupted(25, ['yard']), interrupted(40, ['yard-2']), quoting])).toBeNull();
});
