/** The desk: the place of each panel on this screen. The browser keeps it, and the address contains it if it is not the usual one. */

import {
  DEFAULT_LAYOUT,
  type Layout,
  layoutText,
  moved,
  type Panel,
  parseLayout,
  type SlotName,
  slotOf,
} from './layout';

const KEY = 'sherpa-layout';

export class Desk {
  layout = $state.raw<Layout>(DEFAULT_LAYOUT);
  /** The panel on top of each slot; null means the slot's default. */
  top = $state.raw<Record<SlotName, Panel | null>>({ left: null, right: null });

  /** Takes the layout from an address, or otherwise the one that the browser kept. */
  open(text: string | null): void {
    let kept: string | null = null;
    try {
      kept = window.localStorage.getItem(KEY);
    } catch {
      // A browser without storage keeps nothing.
    }
    this.layout = parseLayout(text ?? kept ?? '') ?? DEFAULT_LAYOUT;
  }

  /** The layout as text; null for the usual one. */
  get text(): string | null {
    return layoutText(this.layout) || null;
  }

  /** Puts a panel on top of its slot. */
  show(panel: Panel): void {
    this.top = { ...this.top, [slotOf(this.layout, panel)]: panel };
  }

  /** Moves a panel to a slot and shows it there. */
  move(panel: Panel, to: SlotName): void {
    this.change(moved(this.layout, panel, to));
    const from = to === 'left' ? 'right' : 'left';
    if (this.top[from] === panel) this.top = { ...this.top, [from]: null };
    this.show(panel);
  }

  resize(widths: [number, number] | null): void {
    this.change({ ...this.layout, widths });
  }

  reset(): void {
    this.change(DEFAULT_LAYOUT);
    this.top = { left: null, right: null };
  }

  private change(layout: Layout): void {
    this.layout = layout;
    try {
      const text = layoutText(layout);
      if (text) window.localStorage.setItem(KEY, text);
      else window.localStorage.removeItem(KEY);
    } catch {
      // The address still holds it.
    }
  }
}
