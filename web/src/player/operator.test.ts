import { afterEach, expect, it, vi } from 'vitest';
import type { ServedFlight } from '../record/operation';
import { Operator } from './operator.svelte';

afterEach(() => {
  vi.restoreAllMocks();
  vi.useRealTimers();
});

/** A server whose clock shows `clock_ms` in each answer, and which does not answer commands. */
function served(clock_ms: () => number) {
  const commands: (number | null)[] = [];
  const flight = {
    operation: async () => ({ clock_ms: clock_ms(), commands: [], authority: { yours: false, epoch: 0 } }),
    command: async (_wish: unknown, _epoch: unknown, until: number | null) => {
      commands.push(until);
      return new Promise<never>(() => {});
    },
  };
  return { flight: flight as unknown as ServedFlight, commands };
}

it('sends commands that are valid for ten seconds by the clock of the server', async () => {
  vi.useFakeTimers();
  const now = vi.spyOn(performance, 'now').mockReturnValue(5_000);
  const { flight, commands } = served(() => 700_000);
  const operator = new Operator(flight);
  void operator.send({ do: 'pause' });
  await operator.watch();
  now.mockReturnValue(6_500);
  void operator.send({ do: 'pause' });
  // Before the first answer nothing is known of the server's clock, and the server's own limit counts.
  expect(commands).toEqual([null, 711_500]);
  operator.close();
});
