/** Boxes of fixed height whose texts can be longer. */

/** Makes a box a stop of the Tab key while its only child is higher than the box, so that the keyboard can scroll it. */
export function scrolls(box: HTMLElement): () => void {
  const content = box.firstElementChild;
  // Sizes are read after the layout of a frame, which costs none.
  const watcher = new ResizeObserver(() => {
    if (box.scrollHeight > box.clientHeight) box.tabIndex = 0;
    else box.removeAttribute('tabindex');
  });
  watcher.observe(box);
  if (content) watcher.observe(content);
  return () => watcher.disconnect();
}
