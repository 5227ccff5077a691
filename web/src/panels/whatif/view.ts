/** The request for a fork, and its progress; pure. */

import type { ForkState } from '../../record/types';
import { missionTime, NANOSECONDS_PER_SECOND } from '../../time/format';

/** One message for each line, at the first whole second after the instant. */
export function inputsOf(messages: string, atNs: number): { t: number; event: string }[] {
  const t = Math.floor(atNs / NANOSECONDS_PER_SECOND) + 1;
  const lines = messages.split('\n').map(line => line.trim());
  return lines.filter(line => line !== '').map(event => ({ t, event }));
}

/** `T+9:10:00, 40 % of the flight`. */
export function progressOf(fork: ForkState, endNs: number): string {
  const share = endNs > 0 ? Math.min(Math.round((100 * fork.now_ns) / endNs), 100) : 0;
  return `${missionTime(fork.now_ns)}, ${share} % of the flight`;
}
