/** Boxes of fixed height whose texts can be longer. */

/**
 * Makes a box scroll, and a stop of the Tab key, while its only child is higher than the box, so that the keyboard can scroll it. Both come
 * at once: a box that scrolls before it can have the focus would shut out the keyboard for a frame.
 */
export function scrolls(box: HTMLElement): () => void {
  const content = box.firstElementChild;
  // Sizes are read after the layout of a frame, which costs none.
  const watcher = new ResizeObserver(() => {
    const isLonger = box.scrollHeight > box.clientHeight;
    box.style.overflowY = isLonger ? 'auto' : '';
    if (isLonger) box.tabIndex = 0;
    else box.removeAttribute('tabindex');
  });
  watcher.observe(box);
  if (content) watcher.observe(content);
  return () => watcher.disconnect();
}
