/** The Operator: the operator's view of a flight under way, and the commands to it. The flight makes all decisions. */

import { type ServedFlight, VALID_MS } from '../record/operation';
import { RecordError } from '../record/source';
import type { CommandState, Operation, Wish } from '../record/types';

/** Time between two readings of the state; it is shorter while a command is on its way, whose age is shown in tenths of seconds. */
const LOOK_MS = 400;
const LOOK_QUICK_MS = 150;

/** A command of this page to which the server has not answered yet. */
export interface SentCommand {
  wish: Wish;
  /** The browser's time at which it was sent, in milliseconds. */
  sentMs: number;
  /** The highest number of a command that the page had seen then: the server's own entry for it has a higher one. */
  after: number;
}

export class Operator {
  /** Null if there is no flight to command: the record is of a past flight, or of another program. */
  operation = $state.raw<Operation | null>(null);
  trouble = $state<string | null>(null);
  /** The commands of this page to which the server has not answered, oldest first. */
  sent = $state.raw<SentCommand[]>([]);
  /** The browser's time in milliseconds; it advances while a command is on its way. */
  nowMs = $state(0);
  /** The browser's time of the last answer, in milliseconds. */
  updatedMs = 0;
  /**
   * The server's clock less the browser's, in milliseconds, by the last answer. The answer was on its way for a while, so the server's clock
   * is at or after this: a command ends early rather than late.
   */
  private clockLead: number | null = null;
  private clock: ReturnType<typeof setInterval> | undefined;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private over = false;

  constructor(private readonly flight: ServedFlight) {}

  /** Reads the state repeatedly, until it is closed or there is no flight. */
  async watch(): Promise<void> {
    clearTimeout(this.timer);
    try {
      this.operation = await this.flight.operation();
      this.updatedMs = performance.now();
      this.clockLead = this.operation ? this.operation.clock_ms - this.updatedMs : null;
      if (this.operation === null) return;
    } catch {
      // The header reports that there is no connection, and the last state stays.
    }
    if (this.over) return;
    const quick = this.operation?.commands.some(command => command.state === 'sent');
    this.timer = setTimeout(() => void this.watch(), quick ? LOOK_QUICK_MS : LOOK_MS);
  }

  close(): void {
    this.over = true;
    clearTimeout(this.timer);
    clearInterval(this.clock);
  }

  /** Sends a command; resolves to its end, or to null if the server has not taken it, which `trouble` explains. */
  async send(wish: Wish): Promise<CommandState | null> {
    this.trouble = null;
    // The holder of authority sends the epoch that the page shows, so that the server rejects the command after a hand-over that the page
    // has not seen.
    const authority = this.operation?.authority;
    const numbers = this.operation?.commands.map(command => command.number) ?? [];
    const one = { wish, sentMs: performance.now(), after: Math.max(0, ...numbers) };
    this.track([...this.sent, one]);
    const until = this.clockLead === null ? null : one.sentMs + this.clockLead + VALID_MS;
    const ended = this.flight.command(wish, authority?.yours ? authority.epoch : null, until);
    setTimeout(() => void this.watch(), 0);
    let end: CommandState | null = null;
    try {
      end = await ended;
    } catch (error) {
      this.trouble = error instanceof RecordError ? `${error.message}; ${error.help}` : String(error);
    }
    this.track(this.sent.filter(other => other !== one));
    await this.watch();
    return end;
  }

  private track(sent: SentCommand[]): void {
    this.sent = sent;
    this.nowMs = performance.now();
    clearInterval(this.clock);
    const tick = () => {
      this.nowMs = performance.now();
    };
    if (sent.length > 0) this.clock = setInterval(tick, LOOK_QUICK_MS);
  }
}
