/** Drawings as SVG: code that draws on a canvas can also draw on a sheet, which writes SVG elements. */

import { save } from './save';

/** The part of a canvas context that drawings use. */
export type Pen = Pick<
  CanvasRenderingContext2D,
  | 'fillStyle'
  | 'strokeStyle'
  | 'lineWidth'
  | 'lineCap'
  | 'lineJoin'
  | 'globalAlpha'
  | 'font'
  | 'textAlign'
  | 'textBaseline'
  | 'save'
  | 'restore'
  | 'translate'
  | 'rotate'
  | 'beginPath'
  | 'closePath'
  | 'moveTo'
  | 'lineTo'
  | 'arc'
  | 'ellipse'
  | 'rect'
  | 'clip'
  | 'fill'
  | 'stroke'
  | 'setLineDash'
  | 'clearRect'
  | 'fillRect'
  | 'strokeRect'
  | 'measureText'
  | 'fillText'
  | 'strokeText'
>;

export interface Paper {
  width: number;
  height: number;
  /** Colour of the ground. */
  ground: string;
  /** A picture below the drawing, as a `data:` address. */
  picture?: string;
  /** Elements above the drawing. */
  above?: string;
}

/** The part of a pen's state that `save` and `restore` keep. */
interface PenState {
  fillStyle: string;
  strokeStyle: string;
  lineWidth: number;
  lineCap: CanvasLineCap;
  lineJoin: CanvasLineJoin;
  globalAlpha: number;
  font: string;
  textAlign: CanvasTextAlign;
  textBaseline: CanvasTextBaseline;
  dash: number[];
  transform: string;
  /** Groups that clip, open since the state was saved. */
  groups: number;
}

const FIRST: PenState = {
  fillStyle: '#000000',
  strokeStyle: '#000000',
  lineWidth: 1,
  lineCap: 'butt',
  lineJoin: 'miter',
  globalAlpha: 1,
  font: '10px sans-serif',
  textAlign: 'start',
  textBaseline: 'alphabetic',
  dash: [],
  transform: '',
  groups: 0,
};
const ANCHORS: Partial<Record<CanvasTextAlign, string>> = { center: 'middle', right: 'end', end: 'end' };

/** A pen that writes SVG elements. `measure` gives the widths of words. */
export class SvgPen implements Pen {
  private state: PenState = { ...FIRST };
  private readonly states: PenState[] = [];
  private readonly parts: string[] = [];
  private path = '';
  private clips = 0;

  constructor(private readonly measure: (text: string, font: string) => TextMetrics) {}

  get fillStyle(): string {
    return this.state.fillStyle;
  }
  set fillStyle(style: string | CanvasGradient | CanvasPattern) {
    this.state.fillStyle = String(style);
  }
  get strokeStyle(): string {
    return this.state.strokeStyle;
  }
  set strokeStyle(style: string | CanvasGradient | CanvasPattern) {
    this.state.strokeStyle = String(style);
  }
  get lineWidth(): number {
    return this.state.lineWidth;
  }
  set lineWidth(width: number) {
    this.state.lineWidth = width;
  }
  get lineCap(): CanvasLineCap {
    return this.state.lineCap;
  }
  set lineCap(cap: CanvasLineCap) {
    this.state.lineCap = cap;
  }
  get lineJoin(): CanvasLineJoin {
    return this.state.lineJoin;
  }
  set lineJoin(join: CanvasLineJoin) {
    this.state.lineJoin = join;
  }
  get globalAlpha(): number {
    return this.state.globalAlpha;
  }
  set globalAlpha(alpha: number) {
    this.state.globalAlpha = alpha;
  }
  get font(): string {
    return this.state.font;
  }
  set font(font: string) {
    this.state.font = font;
  }
  get textAlign(): CanvasTextAlign {
    return this.state.textAlign;
  }
  set textAlign(align: CanvasTextAlign) {
    this.state.textAlign = align;
  }
  get textBaseline(): CanvasTextBaseline {
    return this.state.textBaseline;
  }
  set textBaseline(baseline: CanvasTextBaseline) {
    this.state.textBaseline = baseline;
  }

  save(): void {
    this.states.push(this.state);
    this.state = { ...this.state, groups: 0 };
  }
  restore(): void {
    const before = this.states.pop();
    if (!before) return;
    for (let group = 0; group < this.state.groups; group += 1) this.parts.push('</g>');
    this.state = before;
  }
  translate(x: number, y: number): void {
    this.state.transform += `translate(${px(x)} ${px(y)})`;
  }
  rotate(angle: number): void {
    this.state.transform += `rotate(${px((angle * 180) / Math.PI)})`;
  }
  beginPath(): void {
    this.path = '';
  }
  closePath(): void {
    this.path += 'Z';
  }
  moveTo(x: number, y: number): void {
    this.path += `M${px(x)} ${px(y)}`;
  }
  lineTo(x: number, y: number): void {
    // As on a canvas, a line without a beginning begins here.
    this.path += `${this.path === '' ? 'M' : 'L'}${px(x)} ${px(y)}`;
  }
  arc(x: number, y: number, radius: number, from: number, to: number): void {
    this.ellipse(x, y, radius, radius, 0, from, to);
  }
  /** An arc in the direction of growing angles. */
  ellipse(x: number, y: number, rx: number, ry: number, turn: number, from: number, to: number): void {
    const at = (angle: number) => {
      const [along, across] = [rx * Math.cos(angle), ry * Math.sin(angle)];
      const east = x + along * Math.cos(turn) - across * Math.sin(turn);
      return `${px(east)} ${px(y + along * Math.sin(turn) + across * Math.cos(turn))}`;
    };
    // An SVG arc must not be a whole turn, since it would begin where it ends, so each arc is at most half a turn.
    const halves = Math.max(1, Math.ceil((to - from) / Math.PI - 1e-9));
    const step = (to - from) / halves;
    this.path += `${this.path === '' ? 'M' : 'L'}${at(from)}`;
    for (let half = 1; half <= halves; half += 1)
      this.path += `A${px(rx)} ${px(ry)} ${px((turn * 180) / Math.PI)} 0 1 ${at(from + half * step)}`;
  }
  rect(x: number, y: number, width: number, height: number): void {
    this.path += `M${px(x)} ${px(y)}h${px(width)}v${px(height)}h${px(-width)}Z`;
  }
  clip(): void {
    this.clips += 1;
    this.state.groups += 1;
    const outline = `<path d="${this.path}"${this.placed()}/>`;
    this.parts.push(
      `<clipPath id="clip-${this.clips}">${outline}</clipPath><g clip-path="url(#clip-${this.clips})">`,
    );
  }
  fill(): void {
    if (this.path !== '') this.parts.push(`<path d="${this.path}"${this.filled()}${this.placed()}/>`);
  }
  stroke(): void {
    if (this.path !== '')
      this.parts.push(`<path d="${this.path}" fill="none"${this.stroked()}${this.placed()}/>`);
  }
  setLineDash(dash: Iterable<number>): void {
    this.state.dash = [...dash];
  }
  /** A new sheet is empty, and drawings clear it only at their beginning. */
  clearRect(): void {}
  fillRect(x: number, y: number, width: number, height: number): void {
    this.parts.push(`<rect${box(x, y, width, height)}${this.filled()}${this.placed()}/>`);
  }
  strokeRect(x: number, y: number, width: number, height: number): void {
    this.parts.push(`<rect${box(x, y, width, height)} fill="none"${this.stroked()}${this.placed()}/>`);
  }
  measureText(text: string): TextMetrics {
    return this.measure(text, this.state.font);
  }
  fillText(text: string, x: number, y: number): void {
    this.write(text, x, y, this.filled());
  }
  strokeText(text: string, x: number, y: number): void {
    this.write(text, x, y, ` fill="none"${this.stroked()}`);
  }

  /** The drawing on its paper. */
  svg({ width, height, ground, picture, above = '' }: Paper): string {
    const size = `width="${px(width)}" height="${px(height)}"`;
    const open = this.states.reduce((sum, state) => sum + state.groups, this.state.groups);
    return [
      `<svg xmlns="http://www.w3.org/2000/svg" ${size} viewBox="0 0 ${px(width)} ${px(height)}">`,
      `<rect ${size} fill="${ground}"/>`,
      ...(picture ? [`<image ${size} preserveAspectRatio="none" href="${picture}"/>`] : []),
      ...this.parts,
      `${'</g>'.repeat(open)}${above}</svg>`,
    ].join('\n');
  }

  private write(text: string, x: number, y: number, paint: string): void {
    const { font, textAlign, textBaseline } = this.state;
    const [, weight, size, family = font] = /^(?:(\d+) )?([\d.]+)px (.*)$/.exec(font) ?? [];
    const anchor = ANCHORS[textAlign];
    const attributes = [
      ` x="${px(x)}" y="${px(y)}" font-family="${escaped(family)}"`,
      size ? ` font-size="${size}"` : '',
      weight ? ` font-weight="${weight}"` : '',
      anchor ? ` text-anchor="${anchor}"` : '',
      textBaseline === 'middle' ? ' dy="0.35em"' : '',
    ];
    this.parts.push(`<text${attributes.join('')}${paint}${this.placed()}>${escaped(text)}</text>`);
  }
  private filled(): string {
    const { fillStyle, globalAlpha } = this.state;
    return ` fill="${fillStyle}"${globalAlpha < 1 ? ` fill-opacity="${px(globalAlpha)}"` : ''}`;
  }
  private stroked(): string {
    const { strokeStyle, lineWidth, lineCap, lineJoin, globalAlpha, dash } = this.state;
    return [
      ` stroke="${strokeStyle}" stroke-width="${px(lineWidth)}"`,
      lineCap === 'butt' ? '' : ` stroke-linecap="${lineCap}"`,
      lineJoin === 'miter' ? '' : ` stroke-linejoin="${lineJoin}"`,
      dash.length > 0 ? ` stroke-dasharray="${dash.join(' ')}"` : '',
      globalAlpha < 1 ? ` stroke-opacity="${px(globalAlpha)}"` : '',
    ].join('');
  }
  private placed(): string {
    return this.state.transform === '' ? '' : ` transform="${this.state.transform}"`;
  }
}

/** Saves the drawing made by `draw` as an SVG file. */
export function saveDrawing(name: string, paper: Paper, draw: (pen: Pen) => void): void {
  save(name, 'image/svg+xml', drawingText(paper, draw));
}

/** The drawing made by `draw` as an SVG text. */
export function drawingText(paper: Paper, draw: (pen: Pen) => void): string {
  const ruler = document.createElement('canvas').getContext('2d');
  const pen = new SvgPen((text, font) => {
    if (!ruler) throw new Error('this browser has no canvas');
    ruler.font = font;
    return ruler.measureText(text);
  });
  draw(pen);
  return pen.svg(paper);
}

function box(x: number, y: number, width: number, height: number): string {
  // A canvas draws rectangles of a negative size; SVG does not.
  const [left, top] = [Math.min(x, x + width), Math.min(y, y + height)];
  return ` x="${px(left)}" y="${px(top)}" width="${px(Math.abs(width))}" height="${px(Math.abs(height))}"`;
}

function px(value: number): string {
  return String(Math.round(value * 100) / 100);
}

/** A text as content of an element or of an attribute. */
export function escaped(text: string): string {
  return text.replaceAll('&', '&amp;').replaceAll('<', '&lt;').replaceAll('"', '&quot;');
}
