/** Definitions of all colours: by name for canvases, as `--name` on the root element for style sheets. */

const DARK = {
  ground: '#0f1419',
  panel: '#141a21',
  raised: '#1c242e',
  line: '#27313c',
  text: '#d9e0e8',
  dim: '#93a0ae',
  faint: '#9aa6b3',
  accent: '#4fa8ff',
  danger: '#e5686f',
  /** Attention: only for faults and failures. */
  att: '#ff8a65',
  sea: '#0d141c',
  land: '#1a232c',
  border: '#364553',
  coast: '#3b4b5a',
  graticule: '#1f2a35',
  track: '#35597e',
  flown: '#4fa8ff',
  pending: '#8b98a6',
  enabled: '#d9b24e',
  ongoing: '#3fb68b',
  interrupted: '#e5794b',
  terminated: '#97a3b0',
  known: '#93a0ae',
  planned: '#c3cedb',
  observing: '#ffb938',
  observed: '#45c98a',
  skipped: '#dd5f7c',
  chosen: '#1d3651',
  strip: '#8fb4d8',
  band: '#2a3036',
  ghost: '#7a828b',
  /** Hairlines without information. */
  rule: '#46505a',
  /** Ground that was seen. */
  seen: '#24463a',
  /** Layers of the user. */
  user: '#b48ead',
  halo: '#0d141cd0',
  craft: '#ffffff',
};

/** The name of a colour. */
export type ColourName = keyof typeof DARK;

/** The paper theme: the same roles on a light ground. Text has a contrast of at least 4.5 to 1. */
const LIGHT: Record<ColourName, string> = {
  ground: '#f3f1ec',
  panel: '#fcfbf8',
  raised: '#efece5',
  line: '#cfcbc2',
  text: '#1a1c1e',
  dim: '#4d5358',
  faint: '#5b6065',
  accent: '#0b5cad',
  danger: '#b3330f',
  att: '#b3330f',
  sea: '#e3e0d8',
  land: '#fcfbf8',
  border: '#b9b4a9',
  coast: '#a5a096',
  graticule: '#dad6cc',
  track: '#3b6c9c',
  flown: '#0b5cad',
  pending: '#5b6268',
  enabled: '#7d5a00',
  ongoing: '#17694a',
  interrupted: '#a8481a',
  terminated: '#5b6268',
  known: '#5b6065',
  planned: '#3c444b',
  observing: '#8a5a00',
  observed: '#17693f',
  skipped: '#a82e52',
  chosen: '#d9e6f4',
  strip: '#3b6c9c',
  band: '#e3e0d8',
  ghost: '#838689',
  rule: '#b9b4a9',
  seen: '#cfe3d6',
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
