/** Saves a file that the page made. */

export function save(name: string, type: string, content: string | Blob): void {
  const blob = content instanceof Blob ? content : new Blob([content], { type });
  const link = document.createElement('a');
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

/** Saves the contents of canvases, one above the other, on the ground's colour. */
export function saveCanvases(name: string, canvases: readonly HTMLCanvasElement[], ground: string): void {
  const picture = document.createElement('canvas');
  picture.width = Math.max(...canvases.map(canvas => canvas.width));
  picture.height = Math.max(...canvases.map(canvas => canvas.height));
  const context = picture.getContext('2d');
  if (!context) return;
  context.fillStyle = ground;
  context.fillRect(0, 0, picture.width, picture.height);
  for (const canvas of canvases) context.drawImage(canvas, 0, 0, picture.width, picture.height);
  picture.toBlob(blob => blob && save(name, 'image/png', blob));
}

/** Saves canvases below each other as one picture. */
export function saveStack(name: string, canvases: readonly HTMLCanvasElement[], ground: string): void {
  const picture = document.createElement('canvas');
  picture.width = Math.max(1, ...canvases.map(canvas => canvas.width));
  picture.height = Math.max(
    1,
    canvases.reduce((sum, canvas) => sum + canvas.height, 0),
  );
  const context = picture.getContext('2d');
  if (!context) return;
  context.fillStyle = ground;
  context.fillRect(0, 0, picture.width, picture.height);
  let y = 0;
  for (const canvas of canvases) {
    context.drawImage(canvas, 0, y);
    y += canvas.height;
  }
  picture.toBlob(blob => blob && save(name, 'image/png', blob));
}

/** Saves a drawing with its styles on the page, so that it looks the same elsewhere. */
export function saveSvg(name: string, drawing: SVGSVGElement): void {
  const copy = styledCopy(drawing);
  const ground = document.createElementNS(SVG, 'rect');
  for (const [name, value] of [
    ['width', '100%'],
    ['height', '100%'],
    ['fill', window.getComputedStyle(document.body).backgroundColor],
  ] as const)
    ground.setAttribute(name, value);
  copy.prepend(ground);
  save(name, 'image/svg+xml', new XMLSerializer().serializeToString(copy));
}

/** A copy of a drawing with its styles as attributes, because the content rules of the server forbid styles in markup. */
export function styledCopy(drawing: SVGSVGElement): SVGSVGElement {
  const copy = drawing.cloneNode(true) as SVGSVGElement;
  const [from, to] = [drawing.querySelectorAll('*'), copy.querySelectorAll('*')];
  from.forEach((element, index) => {
    const style = window.getComputedStyle(element);
    for (const name of SVG_STYLES) {
      const value = style.getPropertyValue(name);
      if (value !== '') to[index]?.setAttribute(name, value);
    }
    to[index]?.removeAttribute('style');
  });
  copy.removeAttribute('style');
  copy.setAttribute('xmlns', SVG);
  return copy;
}

const SVG = 'http://www.w3.org/2000/svg';
/** Styles that a drawing takes along. */
const SVG_STYLES = [
  'fill',
  'stroke',
  'stroke-width',
  'stroke-dasharray',
  'font-size',
  'font-family',
  'font-weight',
];

/** Saves an SVG text as a PNG picture. */
export function saveRaster(name: string, svg: string): void {
  const image = new Image();
  const address = URL.createObjectURL(new Blob([svg], { type: 'image/svg+xml' }));
  image.onload = () => {
    const ratio = window.devicePixelRatio || 1;
    const picture = document.createElement('canvas');
    [picture.width, picture.height] = [image.width * ratio, image.height * ratio];
    picture.getContext('2d')?.drawImage(image, 0, 0, picture.width, picture.height);
    URL.revokeObjectURL(address);
    picture.toBlob(blob => blob && save(name, 'image/png', blob));
  };
  image.src = address;
}

/** A table as comma-separated values (RFC 4180). */
export function csv(rows: readonly (readonly (string | number | null)[])[]): string {
  const cell = (value: string | number | null) => {
    const text = value === null ? '' : String(value);
    return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
  };
  return rows.map(row => `${row.map(cell).join(',')}\r\n`).join('');
}
