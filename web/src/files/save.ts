/** Saves a file that the page made. */

export function save(name: string, type: string, content: string | Blob): void {
  const blob = content instanceof Blob ? content : new Blob([content], { type });
  const link = document.createElement('a');
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

/** Saves what canvases show, one above the other, on the ground's colour. */
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

/** A table as comma-separated values (RFC 4180). */
export function csv(rows: readonly (readonly (string | number | null)[])[]): string {
  const cell = (value: string | number | null) => {
    const text = value === null ? '' : String(value);
    return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
  };
  return rows.map(row => `${row.map(cell).join(',')}\r\n`).join('');
}
