import { describe, expect, it } from 'vitest';
import type { Task } from '../../record/types';
import { linesOf, placeOf, proceduresWith } from './view';

const task = (id: number, state: Task['state'], place: string): Task => ({
  id,
  parent: null,
  tag: 't',
  goal: '(g)',
  state,
  outcome: null,
  since_ns: 0,
  created_ns: 0,
  method: null,
  targets: [],
  is_message: false,
  method_place: null,
  place,
});

describe('the program', () => {
  it('marks the lines that are executed', () => {
    const tasks = [
      task(1, 'pending', 'fire.pdl:2:3'),
      task(2, 'ongoing', 'fire.pdl:2:9'),
      task(3, 'terminated', 'fire.pdl:1:1'),
      task(4, 'ongoing', 'other.pdl:1:1'),
    ];
    const lines = linesOf('fire.pdl', ['a', 'b'], tasks, { file: 'fire.pdl', line: 1 });
    expect(lines.map(line => [line.executing, line.here, line.tasks.map(one => one.id)])).toEqual([
      [false, true, []],
      [true, false, [2, 1]],
    ]);
  });

  it('knows places', () => {
    expect(placeOf('C:/a/fire.pdl:14:3')).toEqual({ file: 'C:/a/fire.pdl', line: 14 });
    expect(placeOf('built-in')).toBeNull();
    expect(placeOf(null)).toBeNull();
  });

  it('finds procedures by goal and file', () => {
    const row = (index: string, place: string) => ({ kind: 'procedure', index, place, order: '', steps: [] });
    const program = {
      files: [],
      agents: [],
      resources: [],
      variables: [],
      procedures: [row('(observe ?t)', 'a.pdl:1:1'), row('(land)', 'b.pdl:2:1')],
    };
    expect(proceduresWith(program, 'OBSERVE', new Map()).map(one => one.words)).toEqual(['observe']);
    expect(proceduresWith(program, 'b.pdl', new Map())).toHaveLength(1);
  });
});
