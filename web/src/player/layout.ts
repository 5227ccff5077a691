/** The place of each panel: two slots with panels as tabs, and the widths of the columns; pure. */

import type { Selection } from './address';

/** All panels of the slots. */
export const PANELS = [
  'agenda',
  'objects',
  'program',
  'network',
  'draft',
  'why',
  'monitors',
  'signals',
  'plans',
  'log',
  'alarms',
  'whatif',
  'compare',
  'report',
] as const;
export type Panel = (typeof PANELS)[number];

export type SlotName = 'left' | 'right';

export interface Layout {
  left: Panel[];
  right: Panel[];
  /** Widths of the outer columns in pixels; none follows the screen. */
  widths: [number, number] | null;
}

export const DEFAULT_LAYOUT: Layout = {
  left: ['agenda', 'objects', 'program', 'network', 'draft'],
  right: ['why', 'monitors', 'signals', 'plans', 'log', 'alarms', 'whatif', 'compare', 'report'],
  widths: null,
};

/** Narrowest and widest outer column. */
export const WIDTH_MIN = 240;
export const WIDTH_MAX = 900;

/** The layout with a panel moved to the end of a slot. */
export function moved(layout: Layout, panel: Panel, to: SlotName): Layout {
  const without = (panels: Panel[]) => panels.filter(one => one !== panel);
  const [left, right] = [without(layout.left), without(layout.right)];
  // A slot is never empty: its last panel stays.
  if (left.length === 0 || right.length === 0) return layout;
  return {
    ...layout,
    left: to === 'left' ? [...left, panel] : left,
    right: to === 'right' ? [...right, panel] : right,
  };
}

export function slotOf(layout: Layout, panel: Panel): SlotName {
  return layout.left.includes(panel) ? 'left' : 'right';
}

/** `agenda.objects_why.signals_372.362`; empty for the default. */
export function layoutText(layout: Layout): string {
  const text = [
    layout.left.join('.'),
    layout.right.join('.'),
    layout.widths?.map(Math.round).join('.') ?? '',
  ];
  const words = text.join('_').replace(/_$/, '');
  return words === `${DEFAULT_LAYOUT.left.join('.')}_${DEFAULT_LAYOUT.right.join('.')}` ? '' : words;
}

/** The layout described by a text; null if the text is not a layout. Panels that it does not name are appended to their usual slot. */
export function parseLayout(text: string): Layout | null {
  const [left, right, widths] = text.split('_');
  const panels = (names: string | undefined) => {
    const list = (names ?? '').split('.');
    return list.every(name => PANELS.some(panel => panel === name)) ? (list as Panel[]) : null;
  };
  const [a, b] = [panels(left), panels(right)];
  if (!a || !b || new Set([...a, ...b]).size !== a.length + b.length) return null;
  const named = new Set([...a, ...b]);
  const missing = (list: Panel[]) => list.filter(panel => !named.has(panel));
  const pair = widths?.split('.').map(Number);
  if (pair && (pair.length !== 2 || !pair.every(one => one >= WIDTH_MIN && one <= WIDTH_MAX))) return null;
  return {
    left: [...a, ...missing(DEFAULT_LAYOUT.left)],
    right: [...b, ...missing(DEFAULT_LAYOUT.right)],
    widths: pair ? [pair[0] as number, pair[1] as number] : null,
  };
}

/** The panel that is on top of the right slot until the user chooses another one. */
export function usualPanel(selection: Selection): Panel {
  if (selection && 'task' in selection) return 'why';
  return selection && 'plan' in selection ? 'plans' : 'log';
}
