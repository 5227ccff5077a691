import { describe, expect, it } from 'vitest';
import { allLines, search } from './search';
import type { EventsQuery } from './source';
import type { EventRow, Events } from './types';

const QUERY: EventsQuery = { fromNs: null, toNs: 9, limit: 3, find: 'x', kinds: '', task: null };
const row = (id: number) => ({ id }) as EventRow;

/** Answers with one line each, four in all; the last one ends the search. */
function asked(): { queries: EventsQuery[]; ask: (query: EventsQuery) => Promise<Events> } {
  const queries: EventsQuery[] = [];
  const ask = async (query: EventsQuery): Promise<Events> => {
    queries.push(query);
    const id = (query.before ?? 50) - 10;
    return { events: [row(id)], more: id > 10, next: id > 10 ? id : null };
  };
  return { queries, ask };
}

describe('all lines', () => {
  /** A record with the lines 1 to 5000, in answers of at most 2000. */
  const ask = async ({ before = 5001, limit }: EventsQuery): Promise<Events> => {
    const first = Math.max((before ?? 5001) - Math.min(limit, 2000), 1);
    const ids = Array.from({ length: (before ?? 5001) - first }, (_, index) => row(first + index));
    return { events: ids, more: first > 1, next: null };
  };

  it('are read from several answers, each once, oldest first', async () => {
    const { events, more } = await allLines(ask, QUERY, 100_000);
    expect(events.map(one => one.id)).toEqual(Array.from({ length: 5000 }, (_, index) => index + 1));
    expect(more).toBe(false);
  });

  it('are the newest up to a maximum, and the answer says that there are more', async () => {
    const { events, more } = await allLines(ask, QUERY, 3000);
    expect([events.length, events[0]?.id, more]).toEqual([3000, 2001, true]);
  });
});

describe('search', () => {
  it('continues before the last answer until it has all lines, oldest first', async () => {
    const { queries, ask } = asked();
    const parts: number[] = [];
    const found = await search(
      ask,
      QUERY,
      part => parts.push(part.events.length),
      () => true,
    );
    expect(found.events.map(one => one.id)).toEqual([20, 30, 40]);
    expect(queries.map(query => [query.before, query.limit])).toEqual([
      [undefined, 3],
      [40, 2],
      [30, 1],
    ]);
    expect(parts).toEqual([1, 2]);
    const all = await search(
      ask,
      { ...QUERY, limit: 9 },
      () => undefined,
      () => true,
    );
    expect([all.events.length, all.next, all.more]).toEqual([4, null, false]);
  });

  it('ends with what it has when it is no longer wanted', async () => {
    const { queries, ask } = asked();
    const found = await search(
      ask,
      QUERY,
      () => undefined,
      () => queries.length < 2,
    );
    expect(found.events.map(one => one.id)).toEqual([30, 40]);
    expect(found.next).toBe(30);
  });
});
