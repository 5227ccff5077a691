/** The plots of signals as one SVG text, as drawn in the panel, for documents; pure. */

import type { Range } from '../../player/clock';
import type { SignalWindow } from '../../record/types';
import { COLOURS, MONO, SANS } from '../../theme/colours';
import { NANOSECONDS_PER_SECOND, ticks } from '../../time/format';
import { shownNumber } from '../../units/aviation';
import { columnsOf, signalWords, unitOf, valueRange } from './signals';

const [WIDTH_PX, PLOT_PX, TITLE_PX, NAMES_PX, AXIS_PX, EDGE_PX] = [800, 110, 20, 64, 22, 8];

/** Plots above each other over one time axis, as known at `atNs`. */
export function plotsSvg(windows: readonly SignalWindow[], visible: Range, atNs: number): string {
  const height = windows.length * (PLOT_PX + TITLE_PX) + AXIS_PX;
  const x = (ns: number) =>
    NAMES_PX +
    ((ns - visible.fromNs) / Math.max(visible.toNs - visible.fromNs, 1)) * (WIDTH_PX - NAMES_PX - EDGE_PX);
  const plots = windows.map((window, index) => {
    const top = index * (PLOT_PX + TITLE_PX) + TITLE_PX;
    return plot(window, windows, top, x, visible, atNs);
  });
  const marks = ticks(visible.fromNs, visible.toNs, (WIDTH_PX - NAMES_PX) / 100).map(tick =>
    words(x(tick.atNs), height - 7, tick.label, COLOURS.dim, 'middle'),
  );
  return [
    `<svg xmlns="http://www.w3.org/2000/svg" width="${WIDTH_PX}" height="${height}" viewBox="0 0 ${WIDTH_PX} ${height}" font-family="${escaped(SANS)}" font-size="11">`,
    `<rect width="${WIDTH_PX}" height="${height}" fill="${COLOURS.panel}"/>`,
    ...plots.flat(),
    ...marks,
    '</svg>',
  ].join('\n');
}

function plot(
  window: SignalWindow,
  all: readonly SignalWindow[],
  top: number,
  x: (ns: number) => number,
  visible: Range,
  atNs: number,
): string[] {
  const { factor, unit } = unitOf(window);
  const [low, high] = valueRange(window);
  const y = (value: number) => top + PLOT_PX - ((value - low) / (high - low)) * PLOT_PX;
  const inside = (value: number) => Math.min(Math.max(y(value), top), top + PLOT_PX);
  const [left, right] = [NAMES_PX, WIDTH_PX - EDGE_PX];
  const [times, lows, highs, means] = columnsOf(window, atNs);
  const shown = times.map(time => x(time * NANOSECONDS_PER_SECOND));
  const isWords = window.kind === 'words';
  const parts = [words(left, top - 6, `${signalWords(window, all)}${unit ? `, ${unit}` : ''}`, COLOURS.text)];
  const clip = `clip-${top}`;
  parts.push(
    `<clipPath id="${clip}"><rect x="${left}" y="${top}" width="${right - left}" height="${PLOT_PX}"/></clipPath>`,
    `<g clip-path="url(#${clip})" fill="none">`,
  );
  for (const limit of window.limits) {
    const bounds = [limit.high, limit.low].map(bound => (bound === null ? null : bound * factor));
    if (limit.guarded) {
      const [upper, lower] = [inside(bounds[0] ?? high), inside(bounds[1] ?? low)];
      parts.push(
        `<rect class="limit" x="${left}" y="${px(upper)}" width="${right - left}" height="${px(lower - upper)}" fill="${COLOURS.band}"/>`,
      );
    }
    for (const bound of bounds)
      if (bound !== null)
        parts.push(
          `<path d="M${left} ${px(y(bound))}H${right}" stroke="${COLOURS.faint}" stroke-dasharray="4 3"/>`,
        );
  }
  for (const one of window.excursions) {
    if (one.raised_ns === null || !window.limits[one.limit]?.guarded) continue;
    const from = x(one.from_ns);
    parts.push(
      `<rect class="excursion" x="${px(from)}" y="${top}" width="${px(Math.max(x(one.to_ns) - from, 2))}" height="5" fill="${COLOURS.att}"/>`,
    );
  }
  const band = [
    ...shown.map((at, index) => [at, y(highs[index] ?? 0)]),
    ...shown.map((at, index) => [at, y(lows[index] ?? 0)]).toReversed(),
  ];
  if (!isWords && shown.length > 1)
    parts.push(
      `<polygon points="${band.map(([at, value]) => `${px(at)},${px(value)}`).join(' ')}" fill="${COLOURS.strip}" fill-opacity="0.4"/>`,
    );
  // A value that is a word holds until the next sample.
  const line = shown.map(
    (at, index) =>
      `${index === 0 ? 'M' : isWords ? 'H' : 'L'}${px(at)}${
        index > 0 && isWords ? `V${px(y(means[index] ?? 0))}` : ` ${px(y(means[index] ?? 0))}`
      }`,
  );
  if (line.length > 0)
    parts.push(`<path class="line" d="${line.join('')}" stroke="${COLOURS.strip}" stroke-width="1.2"/>`);
  if (atNs >= visible.fromNs && atNs <= visible.toNs)
    parts.push(`<path d="M${px(x(atNs))} ${top}v${PLOT_PX}" stroke="${COLOURS.craft}" stroke-width="1.5"/>`);
  parts.push(
    '</g>',
    `<rect x="${left}" y="${top}" width="${right - left}" height="${PLOT_PX}" fill="none" stroke="${COLOURS.line}"/>`,
  );
  const labels = isWords
    ? window.words.map((word, index) => [word, index] as const)
    : [high, (low + high) / 2, low].map(value => [shownNumber(value), value] as const);
  for (const [text, value] of labels)
    parts.push(
      words(
        left - 5,
        Math.min(Math.max(y(value) + 4, top + 9), top + PLOT_PX),
        text,
        COLOURS.dim,
        'end',
        MONO,
      ),
    );
  return parts;
}

function words(x: number, y: number, text: string, colour: string, anchor = 'start', font = ''): string {
  const family = font ? ` font-family="${escaped(font)}"` : '';
  return `<text x="${px(x)}" y="${px(y)}" fill="${colour}" text-anchor="${anchor}"${family}>${escaped(text)}</text>`;
}

function px(value = 0): string {
  return String(Math.round(value * 100) / 100);
}

function escaped(text: string): string {
  return text.replaceAll('&', '&amp;').replaceAll('<', '&lt;').replaceAll('"', '&quot;');
}
