/** The Operator: what an operator sees of a flight under way, and the commands to it. It decides nothing: the flight does. */

import type { ServedFlight } from '../record/operation';
import { RecordError } from '../record/source';
import type { Operation, Wish } from '../record/types';

/** The state is read this often; commands on their way are counted in tenths of seconds. */
const LOOK_MS = 400;
const LOOK_QUICK_MS = 150;

export class Operator {
  /** Null where there is no flight to command: a recorded one, or one of another program. */
  operation = $state.raw<Operation | null>(null);
  trouble = $state<string | null>(null);
  private timer: ReturnType<typeof setTimeout> | undefined;
  private over = false;

  constructor(private readonly flight: ServedFlight) {}

  /** Reads the state until it is closed, or there is no flight. */
  async watch(): Promise<void> {
    clearTimeout(this.timer);
    try {
      this.operation = await this.flight.operation();
      if (this.operation === null) return;
    } catch {
      // The header says that there is no connection; the last state stays.
    }
    if (this.over) return;
    const quick = this.operation?.commands.some(command => command.state === 'sent');
    this.timer = setTimeout(() => void this.watch(), quick ? LOOK_QUICK_MS : LOOK_MS);
  }

  close(): void {
    this.over = true;
    clearTimeout(this.timer);
  }

  async send(wish: Wish): Promise<void> {
    this.trouble = null;
    // Who holds authority commands in the epoch that the page shows: after a hand-over unseen here the command is refused.
    const authority = this.operation?.authority;
    const ended = this.flight.command(wish, authority?.yours ? authority.epoch : null);
    setTimeout(() => void this.watch(), 0);
    try {
      await ended;
    } catch (error) {
      this.trouble = error instanceof RecordError ? `${error.message}; ${error.help}` : String(error);
    }
    await this.watch();
  }
}
