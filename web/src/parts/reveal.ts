/** Scrolls a panel so that one of its entries is in sight. The page around it moves only if it shows a part of the panel at most. */

/** Height of what stays at the top of a panel while it scrolls, and space for the next entry. */
const [ABOVE_PX, BELOW_PX] = [96, 36];

/** The distance by which a panel scrolls to show an entry, which may be taller than the panel. */
export function revealPx(
  entry: { top: number; bottom: number },
  panel: { top: number; bottom: number },
): number {
  const above = entry.top - (panel.top + ABOVE_PX);
  const below = entry.bottom - (panel.bottom - BELOW_PX);
  if (above < 0) return above;
  return below > 0 ? Math.min(below, above) : 0;
}

export function reveal(entry: Element | null | undefined): void {
  const panel = entry?.closest('[role="tabpanel"]');
  if (entry && panel)
    panel.scrollTop += revealPx(entry.getBoundingClientRect(), panel.getBoundingClientRect());
}
