import { afterEach, beforeEach, expect, it, vi } from 'vitest';
import type { RecordSource } from '../record/source';
import type { Growth } from '../record/types';
import { readAddress } from './address';
import { Player } from './player.svelte';

beforeEach(() => {
  vi.useFakeTimers();
  vi.stubGlobal('cancelAnimationFrame', () => undefined);
});
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

/** A live record that answers every request, and counts those about targets. */
function liveRecord() {
  let grow: (growth: Growth) => void = () => undefined;
  let asked = 0;
  const mission = { from_ns: 0, end_ns: 60e9, batches: 10, status: 'live', mission: null, agent: null };
  const answers: Record<string, unknown> = {
    mission,
    plans: { plans: [], left_out: 0 },
    troubles: { troubles: [] },
    questions: { questions: [] },
    signals: { signals: [] },
    commandLog: { commands: [] },
    present: { tail: null, wind: null },
    surroundings: { zones: [], landing_places: [] },
  };
  const source = new Proxy({} as RecordSource, {
    get: (_, name: string) => {
      if (name === 'watch')
        return (onGrowth: typeof grow) => {
          grow = onGrowth;
          return () => undefined;
        };
      return async () => {
        if (name === 'targets') asked += 1;
        return name === 'targets' ? [] : (answers[name] ?? null);
      };
    },
  });
  return { source, grow: (growth: Growth) => grow(growth), asked: () => asked };
}

it('a command that a paused flight accepts is read, though mission time stands still', async () => {
  const record = liveRecord();
  const player = new Player(record.source);
  await player.open();
  const paused: Growth = { end_ns: 60e9, batches: 10, status: 'live' };
  record.grow(paused);
  await vi.advanceTimersByTimeAsync(3000);
  const [before, revision] = [record.asked(), player.revision];
  record.grow(paused);
  await vi.advanceTimersByTimeAsync(3000);
  expect(record.asked()).toBe(before);
  record.grow({ ...paused, batches: 11 });
  await vi.advanceTimersByTimeAsync(3000);
  expect(record.asked()).toBeGreaterThan(before);
  // Panels that read on their own read again.
  expect(player.revision).toBe(revision + 1);
  player.close();
});

it('a record is opened with one reading of the instant of the address', async () => {
  const record = liveRecord();
  const player = new Player(record.source);
  const { address } = readAddress('?t=30');
  await player.open(address);
  await vi.advanceTimersByTimeAsync(1000);
  expect(player.atNs).toBe(30e9);
  expect(record.asked()).toBe(1);
  player.seek(20e9);
  await vi.advanceTimersByTimeAsync(1000);
  expect(record.asked()).toBe(2);
  player.close();
});

it('the page takes no keys before it is open: the rest of the opening would undo them', async () => {
  const record = liveRecord();
  let answer: (facts: null) => void = () => undefined;
  const facts = new Promise<null>(resolve => (answer = resolve));
  const slow = new Proxy(record.source, {
    get: (source, name) => (name === 'facts' ? () => facts : source[name as keyof RecordSource]),
  });
  const player = new Player(slow);
  const opened = player.open(readAddress('?t=5').address);
  await vi.advanceTimersByTimeAsync(100);
  expect(player.mission).toBeNull();
  answer(null);
  await opened;
  expect(player.mission).not.toBeNull();
  expect(player.atNs).toBe(5e9);
  player.close();
});

it('the cursor counts as moving until it has been still for a while', async () => {
  const player = new Player(liveRecord().source);
  await player.open(readAddress('?t=5').address);
  await vi.advanceTimersByTimeAsync(1000);
  expect(player.moving).toBe(false);
  player.seek(7e9);
  await vi.advanceTimersByTimeAsync(400);
  player.seek(8e9);
  await vi.advanceTimersByTimeAsync(400);
  expect(player.moving).toBe(true);
  await vi.advanceTimersByTimeAsync(300);
  expect(player.moving).toBe(false);
  player.close();
});
