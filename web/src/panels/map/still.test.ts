import { afterEach, beforeEach, expect, it, vi } from 'vitest';
import { StillPictures } from './still';

/** A canvas with as much of its context as the pictures use. */
function makeCanvas() {
  const canvas = { width: 0, height: 0, getContext: () => context };
  const context = {
    canvas,
    drawn: [] as unknown[],
    save: () => undefined,
    restore: () => undefined,
    resetTransform: () => undefined,
    getTransform: () => 'scale',
    setTransform: () => undefined,
    drawImage: (picture: unknown) => context.drawn.push(picture),
  };
  return { canvas, context };
}

beforeEach(() => vi.stubGlobal('document', { createElement: () => makeCanvas().canvas }));
afterEach(() => vi.unstubAllGlobals());

it('a still part is painted again only if its values or the size of the canvas change', () => {
  const { canvas, context } = makeCanvas();
  [canvas.width, canvas.height] = [300, 200];
  const still = new StillPictures(context as unknown as CanvasRenderingContext2D);
  let painted = 0;
  const draw = (...from: unknown[]) => still.part('ground', from, () => (painted += 1));
  const zones = [{ name: 'tankers' }];
  draw(300, zones);
  draw(300, zones);
  expect(painted).toBe(1);
  expect(context.drawn).toHaveLength(2);
  draw(300, [...zones]);
  expect(painted).toBe(2);
  canvas.height = 220;
  draw(300, zones);
  draw(300, zones);
  expect(painted).toBe(3);
  still.part('symbols', [300, zones], () => (painted += 1));
  expect(painted).toBe(4);
  expect(context.drawn).toHaveLength(6);
});

it('places are computed again only if their values change', () => {
  const still = new StillPictures(makeCanvas().context as unknown as CanvasRenderingContext2D);
  const [first, second] = [
    { symbols: [], labels: [] },
    { symbols: [], labels: [] },
  ];
  expect(still.placed([1], () => first)).toBe(first);
  expect(still.placed([1], () => second)).toBe(first);
  expect(still.placed([2], () => second)).toBe(second);
});
