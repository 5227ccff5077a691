/** Draws targets with their names, and the names of bases and zones, on the map. */

import type { Pen } from '../../files/vector';
import { type Box, labelPlaces, overlap } from '../../parts/labels';
import { COLOURS, SANS, stateColour } from '../../theme/colours';
import type { Frame, Project, Scene } from './draw';
import type { TargetView } from './view';

const PLACE_FONT = `11px ${SANS}`;
export const LABEL_FONT = `600 11.5px ${SANS}`;

/** A name to write, with the places where it lies neither outside of the picture nor on a symbol of a target. */
interface Label {
  text: string;
  font: string;
  colour: string;
  places: Box[];
}

/** The symbols of targets, and the names in the order in which they get places. */
export interface Placed {
  symbols: { target: TargetView; x: number; y: number }[];
  labels: Label[];
}

/** Computes what does not depend on the aircraft. */
export function placed(context: Pen, scene: Scene, frame: Frame, project: Project): Placed {
  const symbols = scene.targets.map(target => ({ target, ...project(target.position) }));
  const taken: Box[] = symbols.map(({ x, y }) => ({ x: x - 7, y: y - 7, width: 14, height: 14 }));
  const labels: Label[] = [];
  const add = (text: string, { x, y }: { x: number; y: number }, font: string, colour: string): void => {
    // A symbol outside the picture gets no label.
    if (x < 0 || y < 0 || x > frame.width || y > frame.height) return;
    context.font = font;
    const places = labelPlaces(x, y, context.measureText(text).width + 2, 13, frame);
    const free = places.filter(place => !taken.some(box => overlap(place, box)));
    labels.push({ text, font, colour, places: free });
  };
  // The selected target and targets in progress get labels first, then targets by value.
  const rank = (target: TargetView) =>
    (target.id === scene.selected ? 1e9 : 0) + (target.state === 'observing' ? 1e6 : 0) + (target.value ?? 0);
  for (const { target, ...at } of symbols.toSorted((a, b) => rank(b.target) - rank(a.target)))
    add(target.name, at, LABEL_FONT, stateColour(target.state));
  for (const place of scene.landingPlaces.filter(one => one.base))
    add(place.name, project([place.longitude_deg, place.latitude_deg]), PLACE_FONT, COLOURS.dim);
  for (const zone of scene.zones.filter(one => one.label !== ''))
    add(zone.label, project(zone.centre), PLACE_FONT, COLOURS.dim);
  return { symbols, labels };
}

/** Writes the names that find a place clear of the aircraft and of the names before them; returns the number of the others. */
export function drawLabels(
  context: Pen,
  { labels }: Placed,
  aircraft: { x: number; y: number } | null,
): number {
  const taken: Box[] = aircraft ? [{ x: aircraft.x - 13, y: aircraft.y - 13, width: 26, height: 26 }] : [];
  let lost = 0;
  context.lineJoin = 'round';
  context.textBaseline = 'middle';
  for (const { text, font, colour, places } of labels) {
    const box = places.find(place => !taken.some(other => overlap(place, other)));
    if (!box) {
      lost += 1;
      continue;
    }
    taken.push(box);
    context.font = font;
    context.lineWidth = 3;
    context.strokeStyle = COLOURS.halo;
    context.strokeText(text, box.x + 1, box.y + 7);
    context.fillStyle = colour;
    context.fillText(text, box.x + 1, box.y + 7);
  }
  context.textBaseline = 'alphabetic';
  return lost;
}

export function drawSymbols(context: Pen, { symbols }: Placed, selected: string | null): void {
  context.lineJoin = context.lineCap = 'round';
  for (const { target, x, y } of symbols) drawSymbol(context, target, x, y, target.id === selected);
}

function drawSymbol(context: Pen, target: TargetView, x: number, y: number, selected: boolean): void {
  const colour = stateColour(target.state);
  if (target.state === 'skipped') {
    // A cross with a halo, so that it stands out from outlines.
    for (const [style, width] of [
      [COLOURS.halo, 5],
      [colour, 2],
    ] as const) {
      context.strokeStyle = style;
      context.lineWidth = width;
      context.beginPath();
      context.moveTo(x - 4, y - 4);
      context.lineTo(x + 4, y + 4);
      context.moveTo(x + 4, y - 4);
      context.lineTo(x - 4, y + 4);
      context.stroke();
    }
  } else {
    context.fillStyle = target.state === 'observed' ? colour : COLOURS.sea;
    context.strokeStyle = colour;
    context.lineWidth = 1.8;
    circle(context, x, y, 4.5);
    context.fill();
    context.stroke();
  }
  if (target.state === 'observing') {
    context.fillStyle = colour;
    context.beginPath();
    context.arc(x, y, 4.5, -Math.PI / 2, Math.PI / 2);
    context.fill();
  }
  if (selected) {
    context.strokeStyle = COLOURS.text;
    context.lineWidth = 1.5;
    circle(context, x, y, 9);
    context.stroke();
  }
}

function circle(context: Pen, x: number, y: number, radius: number): void {
  context.beginPath();
  context.arc(x, y, radius, 0, 2 * Math.PI);
}
