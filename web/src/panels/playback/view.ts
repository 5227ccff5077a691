/** Texts of the playback; pure. */

/** Mission time in relation to watching time: `60×`. */
export function speedText(speed: number): string {
  return `${speed}×`;
}
