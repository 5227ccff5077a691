import { expect, it } from 'vitest';
import type { Pen } from '../../files/vector';
import type { Frame, Scene } from './draw';
import { drawLabels, placed } from './targets';
import { type Box, placeLabel, type TargetView } from './view';

/** A pen that keeps the written names; each letter is 6 pixels wide. */
function namesPen() {
  const written: [string, number, number][] = [];
  const pen = {
    measureText: (text: string) => ({ width: 6 * text.length }),
    strokeText: () => undefined,
    fillText: (...name: [string, number, number]) => written.push(name),
  };
  return { pen: pen as unknown as Pen, written };
}

/** Numbers from 0 to 1, the same in every run. */
function numbers(seed: number): () => number {
  let state = seed;
  return () => {
    state = (state * 1103515245 + 12345) % 2147483648;
    return state / 2147483648;
  };
}

const frame = { width: 372, height: 240 } as Frame;

/** The names by the plain rule: each at the first place that lies on no symbol, on no name before it and not on the aircraft. */
function plainly(targets: readonly TargetView[], aircraft: { x: number; y: number }) {
  const taken: Box[] = targets.map(({ position: [x, y] }) => ({ x: x - 7, y: y - 7, width: 14, height: 14 }));
  taken.push({ x: aircraft.x - 13, y: aircraft.y - 13, width: 26, height: 26 });
  const names: [string, number, number][] = [];
  let lost = 0;
  for (const target of targets.toSorted((a, b) => (b.value ?? 0) - (a.value ?? 0))) {
    const [x, y] = target.position;
    if (x < 0 || y < 0 || x > frame.width || y > frame.height) continue;
    const box = placeLabel(x, y, 6 * target.name.length + 2, 13, taken, frame);
    if (box) {
      taken.push(box);
      names.push([target.name, box.x + 1, box.y + 7]);
    } else lost += 1;
  }
  return { names, lost };
}

it('names lie where the plain rule puts them, wherever the aircraft is', () => {
  const next = numbers(7);
  for (let round = 0; round < 50; round += 1) {
    const targets = Array.from(
      { length: 5 + Math.floor(next() * 60) },
      (_, index): TargetView => ({
        id: `t${index}`,
        name: `Spot ${index}`,
        position: [next() * 420 - 24, next() * 280 - 20],
        state: 'planned',
        sinceNs: null,
        detail: null,
        value: Math.floor(next() * 9),
      }),
    );
    const scene = { targets, landingPlaces: [], zones: [], selected: null } as unknown as Scene;
    const { pen, written } = namesPen();
    const places = placed(pen, scene, frame, ([x, y]) => ({ x, y }));
    for (let move = 0; move < 4; move += 1) {
      const aircraft = { x: next() * frame.width, y: next() * frame.height };
      written.length = 0;
      const lost = drawLabels(pen, places, aircraft);
      expect({ names: written, lost }).toEqual(plainly(targets, aircraft));
    }
  }
});
