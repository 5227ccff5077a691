/** Searches of the trace in several answers: each answer reads a bounded part of the log. */

import type { EventsQuery } from './source';
import type { Events } from './types';

/**
 * The lines of a query, from as many answers as needed. `onPart` gets what is found so far; the search ends early with that once
 * `isWanted` is false.
 */
export async function search(
  ask: (query: EventsQuery) => Promise<Events>,
  query: EventsQuery,
  onPart: (found: Events) => void,
  isWanted: () => boolean,
): Promise<Events> {
  let found = await ask(query);
  while (found.next !== null && found.events.length < query.limit && isWanted()) {
    onPart(found);
    const limit = query.limit - found.events.length;
    const older = await ask({ ...query, before: found.next, limit });
    found = { ...older, events: [...older.events, ...found.events] };
  }
  return found;
}
