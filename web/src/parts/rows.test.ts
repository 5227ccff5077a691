import { describe, expect, it } from 'vitest';
import { type TreeNode, tableOf, visibleRows } from './rows';

const leaf = (id: string): TreeNode<null> => ({ id, words: id, children: [] });
const tree: TreeNode<null>[] = [
  { id: 'a', words: 'a', open: true, children: [leaf('b'), { id: 'c', words: 'c', children: [leaf('d')] }] },
];

describe('rows of a tree', () => {
  it('leave closed branches out', () => {
    expect(visibleRows(tree, new Map()).map(row => row.node.id)).toEqual(['a', 'b', 'c']);
    expect(visibleRows(tree, new Map([['c', true]])).map(row => [row.node.id, row.depth])).toEqual([
      ['a', 0],
      ['b', 1],
      ['c', 1],
      ['d', 2],
    ]);
    expect(visibleRows(tree, new Map([['a', false]])).map(row => row.node.id)).toEqual(['a']);
  });

  it('are all in the table', () => {
    expect(tableOf(tree).map(row => row[2])).toEqual(['what', 'a', 'b', 'c', 'd']);
  });
});
