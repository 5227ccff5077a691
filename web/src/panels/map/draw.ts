/** Draws the moving parts and all words on a canvas above the map. */

import type { Pen } from '../../files/vector';
import type { LandingPlace } from '../../record/types';
import { COLOURS, MONO, stateColour } from '../../theme/colours';
import { drawAbove, drawBelow, drawDraft, type Layers } from './layers';
import { drawLabels, drawSymbols, LABEL_FONT, type Placed, placed } from './targets';
import {
  type Aircraft,
  degreesText,
  graticuleStep,
  type Path,
  type Position,
  type TargetView,
  type ZoneView,
} from './view';

/** From degrees to pixels of the canvas. */
export type Project = (position: Position) => { x: number; y: number };

export interface Scene {
  /** The flown way until the instant. */
  flown: Path;
  aircraft: Aircraft | null;
  /** The aircraft is elsewhere than its reported position, which has a question mark. */
  isUncertain: boolean;
  targets: TargetView[];
  outlines: Map<string, Position[][]>;
  /** The way still to be flown by the plan in force. */
  ahead: Position[];
  zones: ZoneView[];
  landingPlaces: LandingPlace[];
  /** Labels of the last drawing that found no free place. */
  onLost: (labels: number) => void;
  selected: string | null;
  layers: Layers;
  /** True for rotorcraft, which have a separate symbol. */
  rotorcraft: boolean;
}

export interface Frame {
  width: number;
  height: number;
  west: number;
  east: number;
  south: number;
  north: number;
  /** The projection of the ground below, for lines that do not belong to the flight. */
  ground: Project;
}

/** Space at the lower right for the scale bar and the credit. */
const CORNER_PX = 290;
const GRID_FONT = `11px ${MONO}`;

/** The parts of the drawing that do not move with the aircraft. */
export type StillPart = 'ground' | 'symbols';

/** Draws parts that do not move; each is drawn again only when a value of `from` is another one. */
export interface Still {
  part(name: StillPart, from: readonly unknown[], paint: (pen: Pen) => void): void;
  /** The places of targets and names, computed from the same values as the symbols. */
  placed(from: readonly unknown[], compute: () => Placed): Placed;
}

/** Draws each part at once, for drawings that are made once. */
export function drawnAtOnce(context: Pen): Still {
  return { part: (_name, _from, paint) => paint(context), placed: (_from, compute) => compute() };
}

export function draw(
  context: Pen,
  scene: Scene,
  frame: Frame,
  project: Project,
  still: Still = drawnAtOnce(context),
): void {
  context.clearRect(0, 0, frame.width, frame.height);
  const { layers, zones, landingPlaces, targets, selected } = scene;
  const { width, height, west, east, south, north } = frame;
  const view = [width, height, west, east, south, north];
  const { reach, user, seen, ghost, other } = layers;
  const ground = [...view, reach, user, seen, ghost, other, zones, landingPlaces, targets, scene.outlines];
  still.part('ground', ground, pen => {
    pen.lineJoin = pen.lineCap = 'round';
    drawGraticule(pen, frame);
    drawBelow(pen, layers, project);
    drawZones(pen, zones, project);
    drawLandingPlaces(pen, landingPlaces, project);
    drawOutlines(pen, scene, project);
  });
  drawTrack(context, scene, project);
  drawAbove(context, layers, project);
  const symbols = [...view, targets, selected, zones, landingPlaces];
  const places = still.placed(symbols, () => placed(context, scene, frame, project));
  still.part('symbols', symbols, pen => drawSymbols(pen, places, selected));
  scene.onLost(drawLabels(context, places, scene.aircraft && project(scene.aircraft.position)));
  drawDraft(context, layers, project);
  if (scene.aircraft) drawAircraft(context, scene.aircraft, scene.rotorcraft, project);
  if (scene.aircraft && scene.isUncertain) drawUncertain(context, scene.aircraft, project);
}

function drawGraticule(context: Pen, frame: Frame): void {
  const project = frame.ground;
  const step = graticuleStep(frame.east - frame.west);
  context.font = GRID_FONT;
  context.fillStyle = COLOURS.faint;
  context.strokeStyle = COLOURS.graticule;
  context.lineWidth = 1;
  context.beginPath();
  let free = 0;
  for (let count = Math.ceil(frame.west / step); count * step <= frame.east; count += 1) {
    const x = Math.round(project([count * step, frame.south]).x) + 0.5;
    context.moveTo(x, 0);
    context.lineTo(x, frame.height);
    const label = degreesText(count * step, step, 'E', 'W');
    const end = x + 3 + context.measureText(label).width;
    if (x >= free && end < frame.width - CORNER_PX) {
      context.fillText(label, x + 3, frame.height - 5);
      free = end + 6;
    }
  }
  for (let count = Math.ceil(frame.south / step); count * step <= frame.north; count += 1) {
    const y = Math.round(project([frame.west, count * step]).y) + 0.5;
    context.moveTo(0, y);
    context.lineTo(frame.width, y);
    if (y < frame.height - 16) context.fillText(degreesText(count * step, step, 'N', 'S'), 4, y - 3);
  }
  context.stroke();
}

/** Zones active now at the aircraft's altitude are hatched, others outlined; the permitted area is a dashed line. */
function drawZones(context: Pen, zones: readonly ZoneView[], project: Project): void {
  context.strokeStyle = COLOURS.dim;
  context.lineWidth = 1;
  for (const zone of zones) {
    for (const line of zone.lines) {
      context.setLineDash(zone.permitted ? [2, 4] : []);
      polyline(context, line, line.length, project);
      if (zone.active && !zone.permitted) {
        context.save();
        context.clip();
        hatch(context, line, project);
        context.restore();
        polyline(context, line, line.length, project);
      }
      context.stroke();
    }
  }
  context.setLineDash([]);
}

/** Parallel lines over the box of an outline. */
function hatch(context: Pen, line: readonly Position[], project: Project): void {
  const points = line.map(project);
  const [left, right] = [Math.min(...points.map(at => at.x)), Math.max(...points.map(at => at.x))];
  const [top, bottom] = [Math.min(...points.map(at => at.y)), Math.max(...points.map(at => at.y))];
  const height = bottom - top;
  // A zone that extends far beyond the canvas stays without hatch, which would have more lines than the picture has pixels.
  if (right - left + height > 20_000) return;
  context.beginPath();
  for (let x = left - height; x < right; x += 6) {
    context.moveTo(x, bottom);
    context.lineTo(x + height, top);
  }
  context.stroke();
}

function drawLandingPlaces(context: Pen, places: readonly LandingPlace[], project: Project): void {
  context.strokeStyle = COLOURS.dim;
  context.lineWidth = 1.2;
  context.beginPath();
  for (const place of places) {
    const { x, y } = project([place.longitude_deg, place.latitude_deg]);
    const arm = place.base ? 5 : 3;
    context.moveTo(x - arm, y);
    context.lineTo(x + arm, y);
    context.moveTo(x, y - arm);
    context.lineTo(x, y + arm);
  }
  context.stroke();
}

function drawOutlines(context: Pen, scene: Scene, project: Project): void {
  context.lineWidth = 1;
  for (const target of scene.targets) {
    context.strokeStyle = context.fillStyle = stateColour(target.state);
    for (const line of scene.outlines.get(target.id) ?? []) {
      polyline(context, line, line.length, project);
      context.globalAlpha = 0.12;
      context.fill();
      context.globalAlpha = 0.6;
      context.stroke();
      context.globalAlpha = 1;
    }
  }
}

function drawTrack(context: Pen, scene: Scene, project: Project): void {
  const { positions } = scene.flown;
  context.lineJoin = 'round';
  context.lineCap = 'round';
  context.strokeStyle = COLOURS.track;
  context.lineWidth = 1.3;
  context.setLineDash([5, 4]);
  polyline(context, scene.ahead, scene.ahead.length, project);
  context.stroke();
  context.setLineDash([]);
  if (positions.length === 0) return;
  context.strokeStyle = COLOURS.flown;
  context.lineWidth = 2.4;
  polyline(context, positions, positions.length, project);
  context.stroke();
}

function polyline(context: Pen, line: readonly Position[], count: number, project: Project): void {
  context.beginPath();
  for (let index = 0; index < count; index += 1) {
    const { x, y } = project(line[index] as Position);
    if (index === 0) context.moveTo(x, y);
    else context.lineTo(x, y);
  }
}

function drawAircraft(context: Pen, aircraft: Aircraft, rotorcraft: boolean, project: Project): void {
  const { x, y } = project(aircraft.position);
  context.save();
  context.translate(x, y);
  context.rotate((aircraft.headingDeg * Math.PI) / 180);
  if (rotorcraft) {
    drawRotor(context);
    context.restore();
    return;
  }
  // A high-winged aircraft from above: nose up, long wings, a small tail.
  context.beginPath();
  const half: [number, number][] = [
    [0, -12],
    [1.7, -9],
    [1.9, -3],
    [12, 0.5],
    [12, 2.6],
    [1.9, 2],
    [1.4, 8],
    [5, 10.2],
    [5, 11.8],
    [0, 11],
  ];
  for (const [right, down] of half) context.lineTo(right, down);
  for (const [right, down] of half.toReversed()) context.lineTo(-right, down);
  context.closePath();
  context.lineWidth = 3;
  context.strokeStyle = COLOURS.ground;
  context.stroke();
  context.fillStyle = COLOURS.craft;
  context.fill();
  context.restore();
}

/** A dashed circle with a question mark around a position that may be wrong. */
function drawUncertain(context: Pen, aircraft: Aircraft, project: Project): void {
  const { x, y } = project(aircraft.position);
  context.strokeStyle = context.fillStyle = COLOURS.att;
  context.lineWidth = 1.5;
  context.setLineDash([4, 3]);
  context.beginPath();
  context.ellipse(x, y, 18, 18, 0, 0, 2 * Math.PI);
  context.stroke();
  context.setLineDash([]);
  context.font = LABEL_FONT;
  context.fillText('?', x + 15, y - 15);
}

/** A helicopter from above: cabin, boom with tail rotor, and the disc of the main rotor with its blades. */
function drawRotor(context: Pen): void {
  const outline = (widen: number) => {
    context.beginPath();
    context.ellipse(0, -2, 3 + widen, 6 + widen, 0, 0, 2 * Math.PI);
    context.rect(-1 - widen, 3 - widen, 2 + 2 * widen, 10 + 2 * widen);
    context.rect(-3.5 - widen, 11.5 - widen, 7 + 2 * widen, 1.6 + 2 * widen);
  };
  context.fillStyle = COLOURS.ground;
  outline(1.5);
  context.fill();
  context.fillStyle = COLOURS.craft;
  outline(0);
  context.fill();
  context.strokeStyle = COLOURS.craft;
  context.lineWidth = 1.2;
  context.beginPath();
  context.arc(0, -2, 11, 0, 2 * Math.PI);
  context.moveTo(-7.8, -9.8);
  context.lineTo(7.8, 5.8);
  context.moveTo(7.8, -9.8);
  context.lineTo(-7.8, 5.8);
  context.stroke();
}
