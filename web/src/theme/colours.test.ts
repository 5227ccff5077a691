import { describe, expect, it } from 'vitest';
import { applyColours, COLOURS, type ColourName, stateColour } from './colours';

/** The colours of a theme. */
function palette(theme: 'dark' | 'light'): Record<ColourName, string> {
  const style = { colorScheme: '', setProperty: () => undefined };
  applyColours({ dataset: {}, style } as unknown as HTMLElement, theme);
  return { ...COLOURS };
}

function channels(colour: string): [number, number, number] {
  const at = (from: number) => Number.parseInt(colour.slice(from, from + 2), 16);
  return [at(1), at(3), at(5)];
}

/** Relative luminance (WCAG 2.2). */
function luminance(colour: string): number {
  const [red, green, blue] = channels(colour).map(value => {
    const share = value / 255;
    return share <= 0.03928 ? share / 12.92 : ((share + 0.055) / 1.055) ** 2.4;
  }) as [number, number, number];
  return 0.2126 * red + 0.7152 * green + 0.0722 * blue;
}

function contrast(one: string, two: string): number {
  const [low, high] = [luminance(one), luminance(two)].sort((a, b) => a - b) as [number, number];
  return (high + 0.05) / (low + 0.05);
}

const STATES = ['pending', 'enabled', 'ongoing', 'interrupted', 'terminated', 'known'] as const;
const TARGETS = ['planned', 'observing', 'observed', 'skipped'] as const;
/** Roles with a hue: attention, and the user's own layers. */
const HUED = new Set<string>(['danger', 'att', 'failed', 'user']);

describe.each(['dark', 'light'] as const)('the colours of the %s theme', theme => {
  const colours = palette(theme);

  it('have one hue for attention, and none for states', () => {
    for (const [name, colour] of Object.entries(colours)) {
      const values = channels(colour);
      const chroma = Math.max(...values) - Math.min(...values);
      if (HUED.has(name)) expect(chroma, name).toBeGreaterThan(30);
      else expect(chroma, `${name} ${colour}`).toBeLessThanOrEqual(18);
    }
    expect(new Set([colours.danger, colours.att, colours.failed]).size).toBe(1);
  });

  it('give text a contrast of 4.5 on every background', () => {
    const words: ColourName[] = ['text', 'dim', 'faint', 'accent', 'att', 'failed', ...STATES, ...TARGETS];
    for (const word of words)
      for (const ground of ['ground', 'panel', 'raised', 'chosen'] as const)
        expect(contrast(colours[word], colours[ground]), `${word} on ${ground}`).toBeGreaterThanOrEqual(4.5);
  });

  it('give drawings that carry information a contrast of 3 on every background', () => {
    for (const mark of ['track', 'flown', 'other', 'strip', 'ghost', 'craft', ...TARGETS] as const)
      for (const ground of ['sea', 'land', 'panel'] as const)
        expect(contrast(colours[mark], colours[ground]), `${mark} on ${ground}`).toBeGreaterThanOrEqual(3);
  });
});

it('an unknown state has the colour of faint text', () => {
  expect(stateColour('unheard of')).toBe(COLOURS.faint);
  expect(stateColour('failed')).toBe(COLOURS.failed);
});
