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

/** Maximum number of lines in an answer of the server. */
const ANSWER_LINES = 2000;

/** The newest lines of a query, at most `linesMax`, oldest first, from as many answers as needed; `more` is true if older ones are left out. */
export async function allLines(
  ask: (query: EventsQuery) => Promise<Events>,
  query: Omit<EventsQuery, 'limit'>,
  linesMax: number,
): Promise<Events> {
  const parts: Events['events'][] = [];
  let count = 0;
  let before = query.before;
  for (;;) {
    const limit = Math.min(ANSWER_LINES, linesMax - count);
    const part = await ask({ ...query, before, limit });
    parts.push(part.events);
    count += part.events.length;
    before = part.next ?? part.events[0]?.id;
    const over = !part.more || before === undefined || count >= linesMax;
    if (over) return { events: parts.reverse().flat(), more: part.more, next: null };
  }
}
