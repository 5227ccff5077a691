/** The flight under way of a record: its state for an operator, and commands to it. */

import { RecordError } from './source';
import type { CommandState, Operation, Wish } from './types';

/** Time for an answer about the state of the flight; the next request may reach a server that this one has not. */
const ANSWER_MS = 5000;
/** Time from the press of a command until it is no longer valid, in milliseconds. The server has the same limit from its arrival on. */
export const VALID_MS = 10_000;

/** A server that may have a flight under way. */
export class ServedFlight {
  constructor(private readonly base: string) {}

  /** The flight now; null if the server only shows a record. */
  async operation(): Promise<Operation | null> {
    return this.ask<Operation | null>('operation', { signal: AbortSignal.timeout(ANSWER_MS) });
  }

  /**
   * Sends a command, with an epoch of authority if one is given, and with the time of the server's clock until which it is valid; resolves
   * when the command has ended.
   */
  async command(wish: Wish, epoch: number | null, until_ms: number | null = null): Promise<CommandState> {
    return this.ask<CommandState>('commands', {
      method: 'POST',
      headers: { 'Content-Type': 'application/json' },
      body: JSON.stringify({ ...wish, epoch, until_ms }),
    });
  }

  private async ask<T>(what: string, init?: RequestInit): Promise<T> {
    let response: Response;
    try {
      response = await fetch(`${this.base}/api/${what}`, init);
    } catch {
      throw new RecordError('the server does not answer', 'is `apex fly --serve` still running?');
    }
    const body = await response.json();
    // The answer about a server that only shows a record is null.
    if (!response.ok) throw RecordError.of(response, body);
    return body;
  }
}
