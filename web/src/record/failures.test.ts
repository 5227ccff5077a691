import { describe, expect, it } from 'vitest';
import { failures } from './failures';
import type { Trouble } from './types';

const entry = (
  kind: Trouble['kind'],
  subject: string,
  cause: string,
  task: number | null,
  rest: Partial<Trouble> = {},
): Trouble => ({
  t_ns: 5e9,
  kind,
  subject,
  cause,
  task,
  failed_child: null,
  handler_task: null,
  targets: [],
  cause_kind: null,
  handler: null,
  place: null,
  target: null,
  ...rest,
});

describe('failures', () => {
  it('are one alarm where the record has a failure and a fault', () => {
    const cause = 'its subtask T47 failed';
    const fault = '(inspect railway) failed: the mount does not move; (skip railway) handles it';
    const list = failures([
      entry('failed', '(orient camera-1 to railway)', 'the mount does not move', 47),
      entry('fault', fault, cause, 44, { failed_child: 47, handler: '(skip railway)' }),
    ]);
    expect(list.map(one => [one.subject, one.cause])).toEqual([
      ['(orient camera-1 to railway)', 'the mount does not move; (skip railway) handles it'],
    ]);
  });

  it('of a step itself are one alarm without its cause twice', () => {
    const fault = '(fly to home) failed: its command was not answered within PT5M; (land here) handles it';
    const handled = entry('fault', fault, 'command 3 failed: no answer within PT5M', 9, {
      handler: '(land here)',
    });
    expect(failures([handled])).toEqual([{ ...handled, cause: '' }]);
  });

  it('of the initial task are those of the flight', () => {
    const list = failures([
      entry('failed', '(go up)', 'T3 executed (terminate)', 0),
      entry('ended', 'the flight', 'the initial task failed', null),
    ]);
    expect(list.map(one => [one.kind, one.cause, one.task])).toEqual([
      ['ended', 'the initial task failed: T3 executed (terminate)', 0],
    ]);
  });

  it('keep other faults, with their place as the cause where their message is their cause', () => {
    const subject = 'the variable has no value';
    expect(failures([entry('fault', subject, '', 3, { place: 'm.pdl:1:2' })])[0]).toMatchObject({
      subject,
      cause: 'at m.pdl:1:2',
    });
    // Words of a message do not state facts: no task handles this fault.
    const quoted = '"go" failed: no such message; (wait) handles it';
    const kept = entry('fault', quoted, 'its subtask T4 failed to answer', 3);
    expect(failures([entry('failed', '(ask)', 'why', 4), kept])).toContainEqual(kept);
  });
});
