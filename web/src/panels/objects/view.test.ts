import { expect, it } from 'vitest';
import { objectTree, type Things } from './view';

const things: Things = {
  records: [],
  shown: 0,
  program: null,
  tasks: null,
  holdings: null,
  monitors: null,
  signals: null,
  values: new Map(),
  names: new Map(),
  atNs: 0,
};

it('counts objects only once they are known', () => {
  const notes = (known: Partial<Things>) => objectTree({ ...things, ...known }).map(node => node.note);
  expect(notes({})).toEqual(Array(5).fill('not read'));
  const empty = { signals: { signals: [] }, monitors: { at_ns: 0, bindings: [], monitors: [] } };
  expect(notes(empty).slice(3)).toEqual(['0', '0']);
});
