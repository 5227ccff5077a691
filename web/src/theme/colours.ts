/** Definitions of all colours: by name for canvases, as `--name` on the root element for style sheets. */

/**
 * Colours have roles: words, marks, grounds, and one hue for attention. States differ by shape and lightness, never by hue, so that
 * they differ on paper and for everyone.
 */
const DARK = {
  ground: '#14171a',
  panel: '#14171a',
  raised: '#1b1f23',
  line: '#30363c',
  text: '#e8eaec',
  /** Secondary words. */
  dim: '#a9b1b8',
  /** Labels, units, axes. */
  faint: '#989fa7',
  /** What can be pressed, and the focus. */
  accent: '#dfe3e6',
  danger: '#ff8a65',
  /** Attention: only for limit excursions, alarms, open questions and failures. */
  att: '#ff8a65',
  sea: '#111417',
  land: '#1b1f23',
  border: '#3a4148',
  coast: '#4a525a',
  graticule: '#23282d',
  /** The planned way. */
  track: '#a9b1b8',
  /** Lighter than all words, so that tests of pictures recognise it. */
  flown: '#ffffff',
  /** The flown way of the record in the comparison. */
  other: '#8f979f',
  pending: '#989fa7',
  enabled: '#c4cacf',
  ongoing: '#a9b1b8',
  interrupted: '#b4bbc1',
  terminated: '#989fa7',
  failed: '#ff8a65',
  known: '#989fa7',
  planned: '#dfe3e6',
  observing: '#dfe3e6',
  observed: '#dfe3e6',
  skipped: '#a9b1b8',
  chosen: '#2a3036',
  strip: '#dfe3e6',
  band: '#2a3036',
  /** Graphics only, never words. */
  ghost: '#7a828b',
  /** Hairlines without information. */
  rule: '#484f56',
  /** Ground that was seen. */
  seen: '#3f3a30',
  /** Layers of the user. */
  user: '#b48ead',
  halo: '#111417d0',
  craft: '#e8eaec',
};

/** The name of a colour. */
export type ColourName = keyof typeof DARK;

/** The paper theme: the same roles on a light ground. Text has a contrast of at least 4.5 to 1. */
export const LIGHT: Record<ColourName, string> = {
  ground: '#fcfbf8',
  panel: '#fcfbf8',
  raised: '#f3f1ec',
  line: '#cfcbc2',
  text: '#1a1c1e',
  dim: '#4d5358',
  faint: '#5b6065',
  accent: '#25292c',
  danger: '#b3330f',
  att: '#b3330f',
  sea: '#e9e6df',
  land: '#fcfbf8',
  border: '#b9b4a9',
  coast: '#a5a096',
  graticule: '#dad6cc',
  track: '#4d5358',
  flown: '#000000',
  other: '#6a7076',
  pending: '#5b6065',
  enabled: '#3a3f44',
  ongoing: '#4d5358',
  interrupted: '#454b50',
  terminated: '#5b6065',
  failed: '#b3330f',
  known: '#5b6065',
  planned: '#25292c',
  observing: '#25292c',
  observed: '#25292c',
  skipped: '#4d5358',
  chosen: '#e3e0d8',
  strip: '#25292c',
  band: '#e3e0d8',
  ghost: '#7b7e81',
  rule: '#b9b4a9',
  seen: '#e0dbd0',
  user: '#7a4f86',
  halo: '#fcfbf8d0',
  craft: '#1a1c1e',
};

/** The colours of the theme in use. */
export const COLOURS: Record<ColourName, string> = { ...DARK };

const STATE_NAMES = new Set<string>([
  'pending',
  'enabled',
  'ongoing',
  'interrupted',
  'terminated',
  'failed',
  'known',
  'planned',
  'observing',
  'observed',
  'skipped',
]);
/** Fonts for canvases: lists of families to append to a size, the same as in theme.css. */
export const SANS = 'Inter, "Segoe UI", system-ui, "Liberation Sans", "DejaVu Sans", sans-serif';
export const MONO = '"JetBrains Mono", ui-monospace, "Liberation Mono", "DejaVu Sans Mono", monospace';

/** Returns the colour of a task's or a target's state; unknown states have the quiet colour. */
export function stateColour(state: string | null | undefined): string {
  return STATE_NAMES.has(state ?? '') ? COLOURS[state as ColourName] : COLOURS.faint;
}

/** Takes a theme's colours into use, for canvases and style sheets. */
export function applyColours(root: HTMLElement, theme: 'light' | 'dark'): void {
  Object.assign(COLOURS, theme === 'light' ? LIGHT : DARK);
  root.dataset.theme = theme;
  root.style.colorScheme = theme;
  for (const [name, value] of Object.entries(COLOURS)) root.style.setProperty(`--${name}`, value);
}
