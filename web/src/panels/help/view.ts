/** Keys and their actions. */

import type { Player } from '../../player/player.svelte';

/** The action of a key; functions are called with the Player. */
export type Action = 'help' | 'close' | 'fit' | 'find' | 'link' | 'theme' | ((player: Player) => void);

interface Press {
  key: string;
  shiftKey: boolean;
  ctrlKey: boolean;
  metaKey: boolean;
  altKey: boolean;
}

const ACTIONS: Record<string, (press: Press) => Action> = {
  ' ': () => player => player.toggle(),
  ArrowLeft: press => player => player.step(-1, press.shiftKey),
  ArrowRight: press => player => player.step(1, press.shiftKey),
  Home: () => player => player.seek(player.range.fromNs),
  End: () => player => player.follow(),
  ',': () => player => player.changeSpeed(-1),
  '.': () => player => player.changeSpeed(1),
  '+': () => player => player.zoomAt(player.atNs, 0.5),
  '=': () => player => player.zoomAt(player.atNs, 0.5),
  '-': () => player => player.zoomAt(player.atNs, 2),
  '0': () => player => player.showAll(),
  n: () => player => player.goToTrouble(1),
  N: () => player => player.goToTrouble(-1),
  c: () => 'link',
  t: () => 'theme',
  f: () => 'fit',
  '/': () => 'find',
  '?': () => 'help',
  Escape: () => 'close',
};

/** The list that the help shows. */
export const KEYS: { keys: string[]; does: string }[] = [
  { keys: ['Space'], does: 'play or pause' },
  { keys: ['←', '→'], does: 'move the time cursor; with Shift ten times as far' },
  { keys: ['Home', 'End'], does: 'start of the record; end, and follow it while it grows' },
  { keys: [',', '.'], does: 'play slower, play faster' },
  { keys: ['+', '−', '0'], does: 'zoom the timeline around the cursor; show all of it' },
  { keys: ['↑', '↓'], does: 'previous, next row of the tree, list or grid that has the focus' },
  {
    keys: ['←', '→'],
    does: 'there: close and open a branch, or move within the row; Home and End: first and last row',
  },
  { keys: ['Enter'], does: 'open or close the chosen task in the agenda' },
  { keys: ['n', 'N'], does: 'next failure or fault, previous one' },
  { keys: ['c'], does: 'copy a link to this view' },
  { keys: ['t'], does: 'light or dark' },
  { keys: ['/'], does: 'filter the agenda' },
  { keys: ['F'], does: 'show the whole flight on the map' },
  { keys: ['?', 'Esc'], does: 'open and close this help' },
];

/** The action for a key press; none while the user types, except for Escape. */
export function actionFor(press: Press, typing: boolean): Action | undefined {
  if (press.ctrlKey || press.metaKey || press.altKey) return undefined;
  if (typing && press.key !== 'Escape') return undefined;
  return ACTIONS[press.key]?.(press);
}
