/** Rows of resources on the timeline's axis; pure. */

import type { Range } from '../../player/clock';
import type { Holdings } from '../../record/types';
import type { Scale } from './view';
import { NAMES_PX } from './view';

export interface HoldingBar {
  x: number;
  width: number;
  task: number;
  /** Holdings in the bar: more than one if they are narrower than a pixel. */
  count: number;
  words: string;
}

export interface ResourceRowView {
  resource: string;
  bars: HoldingBar[];
  holder: string;
  leftOut: number;
}

/** The holders of each resource, as bars of the window; adjacent holdings narrower than a pixel are one bar with a count. */
export function resourceRows(
  holdings: Holdings | null,
  visible: Range,
  atNs: number,
  scale: Scale,
  phrase: (task: number) => string,
): ResourceRowView[] {
  return (holdings?.resources ?? []).map(row => {
    const bars: HoldingBar[] = [];
    let holder = 'free';
    for (const one of row.holdings) {
      if (one.from_ns > atNs) continue;
      if (one.open || one.to_ns > atNs) holder = `T${one.task} ${phrase(one.task)}`.trim();
      const toNs = Math.min(one.to_ns, atNs, visible.toNs);
      if (toNs < visible.fromNs || one.from_ns > visible.toNs) continue;
      const x = Math.max(scale.x(one.from_ns), NAMES_PX);
      const width = Math.max(scale.x(toNs) - x, 1);
      const last = bars.at(-1);
      const narrow = last && (last.count > 1 || last.width <= 1);
      if (last && narrow && width <= 1 && x - (last.x + last.width) < 1) {
        last.width = Math.max(last.width, x + width - last.x);
        last.count += 1;
        last.words = `${last.count} holdings`;
        continue;
      }
      const amount = one.amount ? `${one.amount}, ` : '';
      bars.push({
        x,
        width,
        task: one.task,
        count: 1,
        words: `${amount}T${one.task} ${phrase(one.task)}`.trim(),
      });
    }
    return { resource: row.resource, bars, holder, leftOut: row.left_out };
  });
}
