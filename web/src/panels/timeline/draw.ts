/** Draws the timeline on a canvas. The cursor is a separate element above it, so that moving the cursor needs no drawing. */

import type { Pen } from '../../files/vector';
import type { Range } from '../../player/clock';
import { COLOURS, MONO, SANS, stateColour } from '../../theme/colours';
import { ticks } from '../../time/format';
import type { Names } from '../../words/phrase';
import {
  AXIS_PX,
  type Block,
  bandsApart,
  blocksOf,
  densityOf,
  type LaneRow,
  lineOf,
  NAMES_PX,
  RAIL_PX,
  ROW_PX,
  type Scale,
  STRIP_PX,
  type Strip,
  type TroubleMark,
  troubleWords,
  VISITS_PX,
  type Visit,
} from './view';

export interface Picture {
  width: number;
  height: number;
  visible: Range;
  /** Nothing later is drawn. */
  atNs: number;
  scale: Scale;
  troubles: TroubleMark[];
  names: Names;
  visits: Visit[];
  strips: Strip[];
  lanes: LaneRow[];
  /** Height of the rows of targets below the axis. */
  gapPx: number;
  /** How far the lanes are scrolled. */
  scrollPx: number;
  selected: number | null;
}

/** Narrowest block that shows the shape of its state, and the distance between lines of a hatch. */
const [SHAPE_PX, HATCH_PX] = [3, 4];
const FONT = `11px ${SANS}`;
const BOLD = `600 11px ${SANS}`;
const NUMBERS = `11px ${MONO}`;
const SMALL = `11px ${MONO}`;

/** Where the lanes begin below rail, axis, visits and strips. */
export function lanesTop(visits: number, strips: number, gapPx = 0): number {
  return RAIL_PX + AXIS_PX + gapPx + (visits > 0 ? VISITS_PX : 0) + strips * STRIP_PX;
}

export function draw(context: Pen, picture: Picture): void {
  context.clearRect(0, 0, picture.width, picture.height);
  context.textBaseline = 'middle';
  const top = lanesTop(picture.visits.length, picture.strips.length, picture.gapPx);
  drawGrid(context, picture);
  context.save();
  context.beginPath();
  context.rect(0, top, picture.width, picture.height - top);
  context.clip();
  context.translate(0, top - picture.scrollPx);
  const bottom = picture.scrollPx + picture.height - top;
  for (const lane of picture.lanes)
    if (lane.y < bottom && lane.y + lane.height > picture.scrollPx) drawLane(context, picture, lane);
  context.restore();
  drawTroubles(context, picture);
  drawAxis(context, picture);
  let y = RAIL_PX + AXIS_PX + picture.gapPx;
  line(context, 0, y - 0.5, picture.width, y - 0.5);
  if (picture.visits.length > 0) {
    drawVisits(context, picture, y);
    y += VISITS_PX;
  }
  for (const strip of picture.strips) {
    drawStrip(context, picture, strip, y);
    y += STRIP_PX;
  }
  line(context, 0, top - 0.5, picture.width, top - 0.5);
  line(context, NAMES_PX - 0.5, 0, NAMES_PX - 0.5, picture.height);
}

function line(context: Pen, x0: number, y0: number, x1: number, y1: number): void {
  context.strokeStyle = COLOURS.line;
  context.lineWidth = 1;
  context.beginPath();
  context.moveTo(x0, y0);
  context.lineTo(x1, y1);
  context.stroke();
}

/** The lines of the time axis through all rows; below everything else. */
function drawGrid(context: Pen, picture: Picture): void {
  context.strokeStyle = COLOURS.graticule;
  context.lineWidth = 1;
  context.beginPath();
  for (const tick of marks(picture)) {
    const x = Math.round(picture.scale.x(tick.atNs)) + 0.5;
    context.moveTo(x, RAIL_PX + AXIS_PX - 5);
    context.lineTo(x, picture.height);
  }
  context.stroke();
}

function drawAxis(context: Pen, picture: Picture): void {
  const { scale, width } = picture;
  context.font = NUMBERS;
  context.fillStyle = COLOURS.dim;
  let free = NAMES_PX;
  for (const tick of marks(picture)) {
    const room = context.measureText(tick.label).width;
    const x = Math.min(Math.round(scale.x(tick.atNs)) + 4, width - room - 3);
    // A label at the edge must not lie on the one before; its line stays.
    if (x < free) continue;
    context.fillText(tick.label, x, RAIL_PX + AXIS_PX / 2);
    free = x + room + 4;
  }
  line(context, 0, RAIL_PX + AXIS_PX - 0.5, width, RAIL_PX + AXIS_PX - 0.5);
}

/** Triangles at the times of failures and faults, with a count where several merge, and words next to the last ones. */
function drawTroubles(context: Pen, picture: Picture): void {
  const total = picture.troubles.reduce((sum, mark) => sum + mark.troubles.length, 0);
  name(context, 'trouble', 8, RAIL_PX / 2, COLOURS.dim); // english: allow
  if (total > 0) {
    context.fillStyle = COLOURS.att;
    context.font = FONT;
    // Without the sign of the header, which counts alarms: the rail also has interruptions, and no questions.
    context.fillText(String(total), 62, RAIL_PX / 2);
  }
  let free = picture.width;
  for (const { x, troubles } of picture.troubles.toReversed()) {
    context.fillStyle = COLOURS.att;
    context.beginPath();
    context.moveTo(x, 3);
    context.lineTo(x + 4.5, RAIL_PX - 3);
    context.lineTo(x - 4.5, RAIL_PX - 3);
    context.fill();
    const last = troubles.at(-1);
    if (!last) continue;
    const text =
      troubles.length > 1
        ? `${troubles.length}× ${troubleWords(last, picture.names)}`
        : troubleWords(last, picture.names); // english: allow
    context.font = FONT;
    const width = context.measureText(text).width;
    if (x + 7 + width < free) context.fillText(text, x + 7, RAIL_PX / 2 + 0.5);
    free = x - 6;
  }
}

function marks({ visible, width }: Picture): { atNs: number; label: string }[] {
  return ticks(visible.fromNs, visible.toNs, (width - NAMES_PX) / 90);
}

function drawVisits(context: Pen, picture: Picture, y: number): void {
  const { scale, visible } = picture;
  name(context, 'target visits', 8, y + VISITS_PX / 2, COLOURS.dim);
  let free = NAMES_PX;
  for (const visit of picture.visits) {
    if (visit.toNs < visible.fromNs || visit.fromNs > Math.min(visible.toNs, picture.atNs)) continue;
    const x = Math.max(scale.x(visit.fromNs), NAMES_PX);
    const width = Math.max(scale.x(Math.min(visit.toNs, visible.toNs)) - x, 3);
    context.fillStyle = stateColour(visit.state);
    context.fillRect(x, y + 3, width, VISITS_PX - 6);
    context.font = BOLD;
    const text = context.measureText(visit.name).width;
    const inside = width >= text + 6;
    const at = inside ? x + 3 : Math.max(x + width + 3, free);
    // A name next to its bar must not overlap the next bar.
    const next = picture.visits.find(other => scale.x(other.fromNs) > x + width);
    if (!inside && (at > x + width + 12 || (next && at + text > scale.x(next.fromNs)))) continue;
    context.fillStyle = inside ? COLOURS.ground : stateColour(visit.state);
    context.fillText(visit.name, at, y + VISITS_PX / 2 + 0.5);
    free = at + text + 4;
  }
}

function drawStrip(context: Pen, picture: Picture, strip: Strip, y: number): void {
  const points = lineOf(strip, picture.visible, picture.scale, y + 4, STRIP_PX - 7);
  context.save();
  context.beginPath();
  context.rect(NAMES_PX, y, picture.width - NAMES_PX, STRIP_PX);
  context.clip();
  context.beginPath();
  for (const [x, height] of points) context.lineTo(x, height);
  context.strokeStyle = COLOURS.strip;
  context.lineWidth = 1.1;
  context.stroke();
  context.restore();
  name(context, strip.name, 8, y + STRIP_PX / 2, COLOURS.dim);
  context.font = SMALL;
  context.fillStyle = COLOURS.faint;
  context.textAlign = 'right';
  if (strip.values.length > 0) {
    context.fillText(strip.high.toFixed(strip.decimals), NAMES_PX - 5, y + 7);
    context.fillText(strip.low.toFixed(strip.decimals), NAMES_PX - 5, y + STRIP_PX - 6);
  }
  context.textAlign = 'left';
  line(context, 0, y + STRIP_PX - 0.5, picture.width, y + STRIP_PX - 0.5);
}

function drawLane(context: Pen, picture: Picture, lane: LaneRow): void {
  const indent = 8 + Math.min(lane.depth, 6) * 8;
  const count = lane.tasks > 1 ? ` ×${lane.tasks}` : '';
  name(context, lane.name + count, indent, lane.y + ROW_PX / 2, COLOURS.text);
  drawBands(context, picture, lane);
  lane.rows.forEach((row, index) => {
    const y = lane.y + index * ROW_PX + 2;
    for (const block of blocksOf(row, picture.visible, picture.atNs, picture.scale)) {
      drawBar(context, block, y, ROW_PX - 4);
      if (block.task !== picture.selected) continue;
      context.strokeStyle = COLOURS.text;
      context.lineWidth = 1.2;
      context.strokeRect(block.x + 0.5, y - 0.5, Math.max(block.width - 1, 1), ROW_PX - 3);
    }
  });
}

/** The shape of a state: pending a line, ready a frame, ongoing a bar, interrupted hatched. */
function drawBar(context: Pen, { x, width, state }: Block, y: number, height: number): void {
  const colour = stateColour(state);
  context.fillStyle = context.strokeStyle = colour;
  if (state === 'pending') {
    context.fillRect(x, y + height / 2 - 0.7, width, 1.4);
    return;
  }
  // Frames and lines need space; a narrow block is filled.
  if (width < SHAPE_PX || state === 'ongoing') {
    context.fillRect(x, y, width, height);
    return;
  }
  context.lineWidth = 1;
  if (state === 'interrupted') {
    context.save();
    context.beginPath();
    context.rect(x, y, width, height);
    context.clip();
    context.beginPath();
    // A bar as wide as the screen has some 300 lines.
    for (let left = x - height; left < x + width; left += HATCH_PX) {
      context.moveTo(left, y + height);
      context.lineTo(left + height, y);
    }
    context.stroke();
    context.restore();
  }
  context.strokeRect(x + 0.5, y + 0.5, Math.max(width - 1, 1), height - 1);
}

/** Dense stretches: a block for each pixel, as high as the share of time with work, and the number of intervals. */
function drawBands(context: Pen, picture: Picture, lane: LaneRow): void {
  const y = lane.y + (bandsApart(lane) ? lane.rows.length * ROW_PX : 0) + 2;
  const height = ROW_PX - 4;
  for (const run of densityOf(lane.bands, picture.visible, picture.atNs, picture.scale)) {
    context.fillStyle = stateColour('ongoing');
    for (const block of run.blocks) {
      const filled = Math.max(block.share * height, 1);
      context.fillRect(block.x, y + height - filled, block.width, filled);
    }
    context.fillStyle = COLOURS.dim;
    context.fillRect(run.x, y - 1, run.width, 1);
    const text = `×${run.count}`;
    context.font = SMALL;
    const width = context.measureText(text).width + 6;
    if (run.count < 2 || run.width < width) continue;
    context.fillStyle = COLOURS.panel;
    context.fillRect(run.x + 2, y + 1, width - 2, height - 2);
    context.fillStyle = COLOURS.text;
    context.fillText(text, run.x + 4, y + height / 2 + 0.5);
  }
}

function name(context: Pen, text: string, x: number, y: number, colour: string): void {
  context.font = FONT;
  context.fillStyle = colour;
  const room = NAMES_PX - x - 8;
  let shown = text;
  while (shown.length > 1 && context.measureText(shown).width > room)
    shown = `${shown.slice(0, -2).trimEnd()}…`;
  context.fillText(shown, x, y);
}
