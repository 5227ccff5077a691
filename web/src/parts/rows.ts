/** Trees as rows; pure. */

export interface TreeNode<T> {
  id: string;
  words: string;
  /** Symbol of the row's state; absent if it has none. */
  glyph?: string;
  /** A value with its unit, on the right. */
  value?: string;
  /** Additional text, on the right. */
  note?: string;
  /** The full text, shown at the pointer. */
  title?: string;
  attention?: boolean;
  chosen?: boolean;
  /** True if a press selects the row; otherwise a press opens or closes it. */
  choosable?: boolean;
  /** True if the row is open at first. */
  open?: boolean;
  data?: T;
  children: TreeNode<T>[];
}

export interface TreeRow<T> {
  node: TreeNode<T>;
  depth: number;
  open: boolean;
  leaf: boolean;
}

/** The rows in reading order; closed branches are left out. */
export function visibleRows<T>(
  nodes: readonly TreeNode<T>[],
  toggled: ReadonlyMap<string, boolean>,
): TreeRow<T>[] {
  const rows: TreeRow<T>[] = [];
  const visit = (node: TreeNode<T>, depth: number) => {
    const leaf = node.children.length === 0;
    const open = !leaf && (toggled.get(node.id) ?? node.open ?? false);
    rows.push({ node, depth, open, leaf });
    if (open) for (const child of node.children) visit(child, depth + 1);
  };
  for (const node of nodes) visit(node, 0);
  return rows;
}

/** The rows of all branches, open or closed, as a table: depth, state, words, value, note. */
export function tableOf<T>(nodes: readonly TreeNode<T>[]): (string | number | null)[][] {
  const all = new Map<string, boolean>();
  const open = (node: TreeNode<T>) => {
    all.set(node.id, true);
    node.children.forEach(open);
  };
  nodes.forEach(open);
  const rows = visibleRows(nodes, all).map(({ node, depth }) => [
    depth,
    node.glyph ?? '',
    node.words,
    node.value ?? '',
    node.note ?? '',
  ]);
  return [['depth', 'state', 'what', 'value', 'note'], ...rows];
}
