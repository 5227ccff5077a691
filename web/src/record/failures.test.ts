import { describe, expect, it } from 'vitest';
import { failures } from './failures';
import type { Trouble } from './types';

const entry = (kind: Trouble['kind'], subject: string, cause: string, task: number | null): Trouble => ({
  t_ns: 5e9,
  kind,
  subject,
  cause,
  task,
  target: null,
});

describe('failures', () => {
  it('are one alarm where the record has a failure and a fault', () => {
    const cause = 'its subtask T47 failed and nothing handles that';
    const list = failures([
      entry('failed', '(orient camera-1 to railway)', 'the mount does not move', 47),
      entry('fault', `${cause}; from missions/diagnosis/mission.pdl:76:3`, cause, 44),
    ]);
    expect(list.map(one => [one.subject, one.cause])).toEqual([
      ['(orient camera-1 to railway)', 'the mount does not move; nothing handles this failure'],
    ]);
  });

  it('of the initial task are those of the flight', () => {
    const list = failures([
      entry('failed', '(go up)', 'T3 did (terminate)', 0),
      entry('ended', 'the flight', 'the initial task failed', null),
    ]);
    expect(list.map(one => [one.kind, one.cause, one.task])).toEqual([
      ['ended', 'the initial task failed: T3 did (terminate)', 0],
    ]);
  });

  it('keep other faults, with their place as the cause', () => {
    const cause = 'the variable has no value';
    expect(failures([entry('fault', `${cause}; from m.pdl:1:2`, cause, 3)])[0]).toMatchObject({
      subject: cause,
      cause: 'at m.pdl:1:2',
    });
  });
});
