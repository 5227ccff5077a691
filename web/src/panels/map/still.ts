/** Keeps the parts of the map that do not move with the aircraft as pictures. */

import type { Pen } from '../../files/vector';
import type { Still, StillPart } from './draw';
import type { Placed } from './targets';

export class StillPictures implements Still {
  private readonly pictures = new Map<StillPart, { picture: HTMLCanvasElement; from: readonly unknown[] }>();
  private places: { from: readonly unknown[]; value: Placed } | null = null;

  /** `context` is that of the canvas on which the pictures are drawn. */
  constructor(private readonly context: CanvasRenderingContext2D) {}

  part(name: StillPart, from: readonly unknown[], paint: (pen: Pen) => void): void {
    const { canvas } = this.context;
    const kept = this.pictures.get(name);
    const { picture } = kept ?? { picture: document.createElement('canvas') };
    const hasSize = picture.width === canvas.width && picture.height === canvas.height;
    if (!kept || !hasSize || !isSame(kept.from, from)) {
      // A new size clears the canvas and its state.
      [picture.width, picture.height] = [canvas.width, canvas.height];
      const pen = picture.getContext('2d');
      if (!pen) {
        paint(this.context);
        return;
      }
      pen.setTransform(this.context.getTransform());
      paint(pen);
      this.pictures.set(name, { picture, from });
    }
    this.context.save();
    this.context.resetTransform();
    this.context.drawImage(picture, 0, 0);
    this.context.restore();
  }

  placed(from: readonly unknown[], compute: () => Placed): Placed {
    if (!this.places || !isSame(this.places.from, from)) this.places = { from, value: compute() };
    return this.places.value;
  }
}

/** True if all values are the same numbers or objects. */
export function isSame(one: readonly unknown[], other: readonly unknown[]): boolean {
  return one.length === other.length && one.every((value, index) => value === other[index]);
}
