/** The height of parts whose texts come and go while the time cursor moves. */

/**
 * Keeps an element at least as high as it was since the cursor began to move, so that the parts below it stay where they are: texts that
 * belong to another instant disappear at once and return with the answer for the new one, and a map that changes its size is drawn again.
 * When the cursor rests, the element has the height of its contents.
 */
export function steady(isMoving: () => boolean): (element: HTMLElement) => () => void {
  return element => {
    let [width, height] = [0, 0];
    let isHeld = false;
    const hold = () => {
      element.style.minHeight = isHeld && height > 0 ? `${height}px` : '';
    };
    const watcher = new ResizeObserver(([entry]) => {
      const size = entry?.borderBoxSize[0];
      if (!size) return;
      // In another width the texts need another height.
      const isGrown = size.blockSize > height || size.inlineSize !== width;
      [width, height] = [size.inlineSize, size.blockSize];
      if (isGrown) hold();
    });
    watcher.observe(element, { box: 'border-box' });
    $effect(() => {
      isHeld = isMoving();
      hold();
    });
    return () => watcher.disconnect();
  };
}
