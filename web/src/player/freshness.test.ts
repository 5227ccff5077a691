import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { Freshness, lateInstant, lateWords, quietWords } from './freshness.svelte';

describe('answers of another instant', () => {
  beforeEach(() => void vi.useFakeTimers());
  afterEach(() => void vi.useRealTimers());

  it('are named with their instant until the last of them has been replaced', () => {
    const freshness = new Freshness();
    freshness.answer('targets', 80);
    freshness.answer('tasks', 80);
    freshness.ask(80);
    vi.advanceTimersByTime(1000);
    expect(freshness.lateNs).toBeNull();
    freshness.ask(20);
    expect(freshness.lateNs).toBeNull();
    vi.advanceTimersByTime(600);
    expect(freshness.lateNs).toBe(80);
    freshness.answer('targets', 20);
    expect(freshness.lateNs).toBe(80);
    freshness.answer('tasks', 20);
    expect(freshness.lateNs).toBeNull();
  });

  it('are not named while the cursor moves and answers follow it', () => {
    const freshness = new Freshness();
    for (let atNs = 0; atNs < 40; atNs += 1) {
      freshness.ask(atNs + 1);
      freshness.answer('targets', atNs);
      vi.advanceTimersByTime(100);
      expect(freshness.lateNs).toBeNull();
    }
    vi.advanceTimersByTime(600);
    expect(freshness.lateNs).toBe(39);
  });

  it('are named while the cursor moves if only those of another subject follow it', () => {
    const freshness = new Freshness();
    freshness.answer('tasks', 0);
    for (let atNs = 1; atNs < 10; atNs += 1) {
      freshness.ask(atNs);
      freshness.answer('targets', atNs);
      vi.advanceTimersByTime(100);
    }
    expect(freshness.lateNs).toBe(0);
    freshness.play(true);
    expect(freshness.lateNs).toBeNull();
    vi.advanceTimersByTime(2000);
    expect(freshness.lateNs).toBe(0);
  });

  it('have the farthest of several instants', () => {
    const shown = new Map(Object.entries({ targets: 50, tasks: 90, plans: 60 }));
    expect(lateInstant(shown, 60)).toBe(90);
    expect(lateInstant(new Map([['targets', 60]]), 60)).toBeNull();
  });
});

it('a failure stays until a request for the same subject succeeds', () => {
  const freshness = new Freshness();
  freshness.fail('targets', { error: 'disk gone', help: 'replace it' });
  freshness.answer('tasks', 1);
  expect([...freshness.failures.values()]).toEqual([{ error: 'disk gone', help: 'replace it' }]);
  freshness.answer('targets', 1);
  expect(freshness.failures.size).toBe(0);
  freshness.stop();
});

it('a late instant is named next to that of the cursor', () => {
  expect(lateWords(80_000e9, 2_000e9, false)).toBe(
    'reading T+0:33:20 …: parts of the page still show T+22:13:20',
  );
  expect(lateWords(2_000e9, 2_000.5e9, true)).toContain('T+0:33:20.500 could not be read');
});

it('a live flight without updates is named after three seconds', () => {
  expect(quietWords(13_000, 10_000)).toBeNull();
  expect(quietWords(22_400, 10_000)).toBe('no update for 12 s: the page shows the flight as it was then');
});
