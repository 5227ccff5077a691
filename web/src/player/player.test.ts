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
