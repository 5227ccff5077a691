/**
 * One tab stop for a list or grid of buttons: the arrow keys move between rows and within one, Home and End to the first and the last row.
 * The keys do not reach the page, where they move the time cursor.
 */

/** The elements of a row, and the rows themselves. */
const [ITEMS, ROWS] = ['button, summary, [role="button"]', 'tr, li, [role="row"]'];

type Item = HTMLElement | SVGElement;

export interface Place {
  row: number;
  item: number;
}

/** The place to which a key moves from `at`, in rows with these numbers of items; null for other keys. */
export function placeAfter(key: string, at: Place, sizes: readonly number[]): Place | null {
  const last = sizes.length - 1;
  const inRow = (row: number, item: number) => ({
    row,
    item: Math.min(item, Math.max((sizes[row] ?? 1) - 1, 0)),
  });
  // In a single row, up and down move as left and right do.
  if (last === 0 && (key === 'ArrowDown' || key === 'ArrowUp'))
    return placeAfter(key === 'ArrowDown' ? 'ArrowRight' : 'ArrowLeft', at, sizes);
  switch (key) {
    case 'ArrowDown':
      return inRow(Math.min(at.row + 1, last), at.item);
    case 'ArrowUp':
      return inRow(Math.max(at.row - 1, 0), at.item);
    case 'ArrowRight':
      return inRow(at.row, at.item + 1);
    case 'ArrowLeft':
      return inRow(at.row, Math.max(at.item - 1, 0));
    case 'Home':
      return inRow(0, at.item);
    case 'End':
      return inRow(last, at.item);
    default:
      return null;
  }
}

/** Makes the buttons of an element one tab stop. */
export function roving(box: Item): () => void {
  let current: Item | null = null;
  const rows = (): Item[][] => {
    const found = new Map<Element, Item[]>();
    for (const item of box.querySelectorAll<Item>(ITEMS)) {
      const row = item.closest(ROWS) ?? box;
      found.set(row, [...(found.get(row) ?? []), item]);
    }
    return [...found.values()];
  };
  const mark = () => {
    const items = rows().flat();
    if (!current || !items.includes(current)) current = items[0] ?? null;
    for (const item of items) {
      const index = item === current ? '0' : '-1';
      if (item.getAttribute('tabindex') !== index) item.setAttribute('tabindex', index);
    }
  };
  const onfocusin = (event: Event) => {
    const item = event.target instanceof Element ? event.target.closest<Item>(ITEMS) : null;
    if (!item || !box.contains(item)) return;
    current = item;
    mark();
  };
  const onkeydown = (event: Event) => {
    if (!(event instanceof KeyboardEvent)) return;
    if (event.ctrlKey || event.metaKey || event.altKey || event.target instanceof HTMLInputElement) return;
    const all = rows();
    const row = all.findIndex(items => current !== null && items.includes(current));
    if (row < 0 || !current) return;
    const at = { row, item: all[row]?.indexOf(current) ?? 0 };
    const to = placeAfter(
      event.key,
      at,
      all.map(items => items.length),
    );
    const next = to && all[to.row]?.[to.item];
    if (!next) return;
    event.preventDefault();
    event.stopPropagation();
    next.focus();
  };
  const watcher = new MutationObserver(mark);
  watcher.observe(box, { childList: true, subtree: true });
  box.addEventListener('focusin', onfocusin);
  box.addEventListener('keydown', onkeydown);
  mark();
  return () => {
    watcher.disconnect();
    box.removeEventListener('focusin', onfocusin);
    box.removeEventListener('keydown', onkeydown);
  };
}
