import { describe, expect, it } from 'vitest';
import { DEFAULT_LAYOUT, layoutText, moved, PANELS, parseLayout, slotOf, usualPanel } from './layout';

describe('the layout', () => {
  it('holds each panel once', () => {
    expect([...DEFAULT_LAYOUT.left, ...DEFAULT_LAYOUT.right].sort()).toEqual([...PANELS].sort());
  });

  it('is read back as it was written', () => {
    const layout = { ...moved(DEFAULT_LAYOUT, 'signals', 'left'), widths: [400, 500] as [number, number] };
    expect(slotOf(layout, 'signals')).toBe('left');
    expect(parseLayout(layoutText(layout))).toEqual(layout);
    expect(layoutText(DEFAULT_LAYOUT)).toBe('');
  });

  it('never empties a slot', () => {
    const lone = { left: ['agenda' as const], right: ['why' as const], widths: null };
    expect(moved(lone, 'agenda', 'right')).toEqual(lone);
  });

  it('refuses other texts, and adds panels that a text does not name', () => {
    expect(parseLayout('agenda_sofa')).toBeNull();
    expect(parseLayout('agenda_agenda')).toBeNull();
    expect(parseLayout('agenda_why_10.20')).toBeNull();
    const short = parseLayout('agenda_why');
    expect(short?.left[0]).toBe('agenda');
    expect([...(short?.left ?? []), ...(short?.right ?? [])].sort()).toEqual([...PANELS].sort());
  });
});

it('the usual panel on the right shows what is selected', () => {
  expect(usualPanel(null)).toBe('log');
  expect(usualPanel({ target: 'barn' })).toBe('log');
  expect(usualPanel({ event: 12 })).toBe('log');
  expect(usualPanel({ task: 12 })).toBe('why');
  expect(usualPanel({ plan: 2 })).toBe('plans');
});
