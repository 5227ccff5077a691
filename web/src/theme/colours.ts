/** All colours, once: for canvases by name, for style sheets as `--name` on the root element. */

export const COLOURS = {
  ground: '#0f1419',
  panel: '#141a21',
  raised: '#1c242e',
  line: '#27313c',
  text: '#d9e0e8',
  dim: '#93a0ae',
  faint: '#677483',
  accent: '#4fa8ff',
  danger: '#e5686f',
  sea: '#0d141c',
  land: '#1a232c',
  border: '#364553',
  coast: '#3b4b5a',
  graticule: '#1f2a35',
  track: '#35597e',
  flown: '#4fa8ff',
  pending: '#7f8c9b',
  enabled: '#d9b24e',
  ongoing: '#3fb68b',
  interrupted: '#e5794b',
  terminated: '#566270',
  planned: '#c3cedb',
  observing: '#ffb938',
  observed: '#45c98a',
  skipped: '#dd5f7c',
} as const;

const STATE_COLOURS: Record<string, string> = {
  pending: COLOURS.pending,
  enabled: COLOURS.enabled,
  ongoing: COLOURS.ongoing,
  interrupted: COLOURS.interrupted,
  terminated: COLOURS.terminated,
  planned: COLOURS.planned,
  observing: COLOURS.observing,
  observed: COLOURS.observed,
  skipped: COLOURS.skipped,
};

/** Fonts for canvases: family lists that follow a size. They are those of theme.css. */
export const SANS = 'Inter, "Segoe UI", system-ui, "Liberation Sans", "DejaVu Sans", sans-serif';
export const MONO = '"JetBrains Mono", ui-monospace, "Liberation Mono", "DejaVu Sans Mono", monospace';

/** The colour of a task's or a target's state; states unknown here are quiet. */
export function stateColour(state: string | null | undefined): string {
  return STATE_COLOURS[state ?? ''] ?? COLOURS.faint;
}

/** Makes the colours known to style sheets. */
export function applyColours(root: HTMLElement): void {
  for (const [name, value] of Object.entries(COLOURS)) root.style.setProperty(`--${name}`, value);
}
