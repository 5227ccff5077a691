/** Whether what the page shows belongs to the cursor's instant: answers may be late, or may fail. */

import { missionTime, NANOSECONDS_PER_SECOND } from '../time/format';

/** Time after which a late answer is named; longer than the rest of the now line between two requests. */
const LATE_MS = 500;
/** The same while the cursor plays, when answers follow it at some distance. */
const LATE_PLAYING_MS = 2000;

export interface Failure {
  error: string;
  help: string;
}

/** The instant of a late answer that is shown: of several the one farthest from the cursor; null if all belong to the cursor's instant. */
export function lateInstant(shown: ReadonlyMap<string, number>, atNs: number): number | null {
  let farthest: number | null = null;
  for (const instant of shown.values()) {
    if (instant === atNs) continue;
    if (farthest === null || Math.abs(instant - atNs) > Math.abs(farthest - atNs)) farthest = instant;
  }
  return farthest;
}

/** `reading T+0:33:20 …: parts of the page still show T+22:13:20`. */
export function lateWords(lateNs: number, atNs: number, failed: boolean): string {
  const decimals = Math.abs(lateNs - atNs) < NANOSECONDS_PER_SECOND ? 3 : 0;
  const [late, now] = [missionTime(lateNs, decimals), missionTime(atNs, decimals)];
  const read = failed ? `${now} could not be read` : `reading ${now} …`;
  return `${read}: parts of the page still show ${late}`;
}

/** Time without updates from a live flight after which the page states it. */
const QUIET_MS = 3000;

/** `no update for 12 s: the page shows the flight as it was then`; null while there are updates. Times are of the browser, in milliseconds. */
export function quietWords(nowMs: number, updatedMs: number): string | null {
  const quiet = nowMs - updatedMs;
  if (quiet <= QUIET_MS) return null;
  return `no update for ${Math.floor(quiet / 1000)} s: the page shows the flight as it was then`;
}

export class Freshness {
  /** The instant that some shown answers belong to, once they have been late for a while; null while none is late. */
  lateNs = $state<number | null>(null);
  /** Failed requests by subject, until a request for that subject succeeds. */
  failures = $state.raw<ReadonlyMap<string, Failure>>(new Map());
  private readonly shown = new Map<string, number>();
  /** The time at which an answer of another instant was shown, or at which the cursor left its instant. */
  private readonly since = new Map<string, number>();
  private atNs = 0;
  private limitMs = LATE_MS;
  private timer: ReturnType<typeof setTimeout> | undefined;

  /** The cursor is at this instant. */
  ask(atNs: number): void {
    this.atNs = atNs;
    for (const [subject, instant] of this.shown) {
      if (instant === atNs) this.since.delete(subject);
      else if (!this.since.has(subject)) this.since.set(subject, performance.now());
    }
    this.check();
  }

  /** The cursor begins or ends to play. */
  play(playing: boolean): void {
    this.limitMs = playing ? LATE_PLAYING_MS : LATE_MS;
    this.check();
  }

  /** The answer about a subject that belongs to `atNs` is shown from now on. */
  answer(subject: string, atNs: number): void {
    this.succeed(subject);
    this.shown.set(subject, atNs);
    // While the cursor moves, each answer is one of an earlier instant; only a subject without answers is late.
    if (atNs === this.atNs) this.since.delete(subject);
    else this.since.set(subject, performance.now());
    this.check();
  }

  /** False while an answer for the cursor's instant is awaited; a failed request is not. */
  get isCurrent(): boolean {
    return [...this.since.keys()].every(subject => this.failures.has(subject));
  }

  /** A request for a subject that does not depend on the instant has succeeded. */
  succeed(subject: string): void {
    if (!this.failures.has(subject)) return;
    const rest = new Map(this.failures);
    rest.delete(subject);
    this.failures = rest;
  }

  fail(subject: string, failure: Failure): void {
    this.failures = new Map(this.failures).set(subject, failure);
  }

  /** Ends all timers. */
  stop(): void {
    clearTimeout(this.timer);
    this.timer = undefined;
  }

  private check(): void {
    this.stop();
    const now = performance.now();
    const late = [...this.since]
      .filter(([, since]) => now - since >= this.limitMs)
      .map(([subject]) => subject);
    this.lateNs = lateInstant(
      new Map(late.map(subject => [subject, this.shown.get(subject) ?? 0])),
      this.atNs,
    );
    const waiting = [...this.since.values()]
      .map(since => since + this.limitMs - now)
      .filter(rest => rest > 0);
    if (waiting.length > 0) this.timer = setTimeout(() => this.check(), Math.ceil(Math.min(...waiting)));
  }
}
