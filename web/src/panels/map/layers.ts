/** Draws the layers below the flown track: seen ground, reach, the replaced plan, weak links, winds, the user's layers. */

import type { Pen } from '../../files/vector';
import { COLOURS, MONO } from '../../theme/colours';
import { CALM, type SeenPatch, type UserLayer, type WindArrow, windText } from './air';
import type { Project } from './draw';
import type { Position } from './view';

export interface Layers {
  seen: SeenPatch[];
  /** Circles around landing places within which the mission lets the vehicle fly. */
  reach: Position[][];
  /** The way of the plan before the one in force. */
  ghost: Position[];
  /** Stretches of the flown track with a link below its limit. */
  weak: Position[][];
  winds: WindArrow[];
  user: UserLayer[];
  /** The flown track of the record in the comparison. */
  other: Position[];
  /** Places of the visits of a drawn plan, and the place of the visit that is impossible. */
  draft: Position[];
  draftFault: number | null;
}

/** Pixels between two wind arrows. */
const ARROW_GAP_PX = 46;

export function drawBelow(context: Pen, layers: Layers, project: Project): void {
  drawReach(context, layers.reach, project);
  drawUser(context, layers.user, project);
  drawSeen(context, layers.seen, project);
  drawGhost(context, layers.ghost, project);
  drawOther(context, layers.other, project);
}

/** Draws the layers above the flown track. */
export function drawAbove(context: Pen, layers: Layers, project: Project): void {
  drawWeak(context, layers.weak, project);
  drawWinds(context, layers.winds, project);
}

/** The drawn plan is above everything: its visits are numbered in order, with a triangle at a visit that is impossible. */
export function drawDraft(context: Pen, layers: Layers, project: Project): void {
  if (layers.draft.length === 0) return;
  context.strokeStyle = COLOURS.text;
  context.lineWidth = 1.6;
  context.setLineDash([9, 3, 2, 3]);
  context.beginPath();
  trace(context, layers.draft, project);
  context.stroke();
  context.setLineDash([]);
  context.font = `600 11px ${MONO}`;
  context.textAlign = 'center';
  context.textBaseline = 'middle';
  layers.draft.forEach((position, index) => {
    const { x, y } = project(position);
    const wrong = index === layers.draftFault;
    context.fillStyle = wrong ? COLOURS.att : COLOURS.text;
    context.beginPath();
    if (wrong) {
      context.moveTo(x, y - 13);
      context.lineTo(x + 12, y + 9);
      context.lineTo(x - 12, y + 9);
    } else context.arc(x, y, 9, 0, 2 * Math.PI);
    context.fill();
    context.fillStyle = COLOURS.panel;
    context.fillText(String(index + 1), x, y + (wrong ? 2 : 0.5));
  });
  context.textAlign = 'left';
  context.textBaseline = 'alphabetic';
}

/** The track of the other record: thin, below the track of the shown one. */
function drawOther(context: Pen, way: readonly Position[], project: Project): void {
  context.strokeStyle = COLOURS.other;
  context.lineWidth = 1.4;
  context.beginPath();
  trace(context, way, project);
  context.stroke();
}

function trace(context: Pen, line: readonly Position[], project: Project): void {
  line.forEach((position, index) => {
    const { x, y } = project(position);
    if (index === 0) context.moveTo(x, y);
    else context.lineTo(x, y);
  });
}

/** The outlines of the circles: inside of one, a landing place is near enough. */
function drawReach(context: Pen, circles: readonly Position[][], project: Project): void {
  context.strokeStyle = COLOURS.rule;
  context.lineWidth = 1;
  context.setLineDash([1, 4]);
  context.beginPath();
  for (const circle of circles) trace(context, circle, project);
  context.stroke();
  context.setLineDash([]);
}

function drawUser(context: Pen, layers: readonly UserLayer[], project: Project): void {
  context.strokeStyle = COLOURS.user;
  context.fillStyle = COLOURS.user;
  context.lineWidth = 1.2;
  for (const layer of layers) {
    context.beginPath();
    for (const line of layer.lines) trace(context, line, project);
    context.stroke();
    for (const point of layer.points) {
      const { x, y } = project(point);
      context.fillRect(x - 2, y - 2, 4, 4);
    }
  }
}

function drawSeen(context: Pen, patches: readonly SeenPatch[], project: Project): void {
  for (const valid of [false, true]) {
    context.fillStyle = valid ? COLOURS.seen : COLOURS.band;
    for (const patch of patches) {
      if (patch.valid !== valid) continue;
      context.beginPath();
      trace(context, patch.outline, project);
      context.closePath();
      context.fill();
    }
  }
}

function drawGhost(context: Pen, way: readonly Position[], project: Project): void {
  context.strokeStyle = COLOURS.ghost;
  context.lineWidth = 1.5;
  context.setLineDash([1.5, 5]);
  context.beginPath();
  trace(context, way, project);
  context.stroke();
  context.setLineDash([]);
}

/** A weak link is a dotted gap on the flown track: its colour is that of the ground. */
function drawWeak(context: Pen, ways: readonly Position[][], project: Project): void {
  context.strokeStyle = COLOURS.sea;
  context.lineWidth = 3;
  context.setLineDash([2, 4]);
  context.beginPath();
  for (const way of ways) trace(context, way, project);
  context.stroke();
  context.setLineDash([]);
}

/** Arrows that point in the direction to which the wind blows, with a feather for each 10 kt. */
function drawWinds(context: Pen, winds: readonly WindArrow[], project: Project): void {
  context.strokeStyle = COLOURS.dim;
  context.lineWidth = 1.1;
  context.font = `11px ${MONO}`;
  let last: { x: number; y: number } | null = null;
  for (const wind of winds) {
    if (windText(wind) === CALM) continue;
    const { x, y } = project(wind.position);
    if (last && Math.hypot(x - last.x, y - last.y) < ARROW_GAP_PX) continue;
    last = { x, y };
    const towards = ((wind.fromDeg + 180) * Math.PI) / 180;
    context.save();
    context.translate(x, y);
    context.rotate(towards);
    context.beginPath();
    context.moveTo(0, 12);
    context.lineTo(0, -10);
    context.moveTo(-3, -5);
    context.lineTo(0, -10);
    context.lineTo(3, -5);
    const feathers = Math.min(Math.round((wind.speedMps * 3600) / 1852 / 10), 8);
    for (let feather = 0; feather < feathers; feather += 1) {
      context.moveTo(0, 12 - feather * 3);
      context.lineTo(5, 14 - feather * 3);
    }
    context.stroke();
    context.restore();
  }
}
