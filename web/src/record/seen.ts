/** The map's requests to a record: the signals along the flown track. */

import type { Signal } from './types';

/** The signals that the map draws along the flown track. */
export function airSignals(signals: readonly Signal[]): { wind: [string, string] | null; links: Signal[] } {
  const named = (attribute: string) => signals.find(signal => signal.attribute === attribute)?.name;
  const [speed, direction] = [named('wind-speed'), named('wind-direction')];
  return {
    wind: speed && direction ? [speed, direction] : null,
    links: signals.filter(signal => signal.attribute === 'signal-level' && signal.kind === 'number'),
  };
}
