/** The flight under way behind a record: its state for a person, and commands to it. */

import { RecordError } from './source';

export interface OpenQuestion {
  agent: string;
  question: number;
  text: string;
  /** The choices; none if any answer is taken. */
  options: string[];
  /** Taken at the deadline; none fails the task. */
  default: string | null;
  asked_ns: number;
  by_ns: number | null;
}

/** A command and its end: exactly one of accepted, rejected and expired. */
export interface CommandState {
  number: number;
  words: string;
  state: 'sent' | 'accepted' | 'rejected' | 'expired';
  at_ns: number | null;
  reason: string | null;
  age_s: number;
}

export interface Operation {
  now_ns: number;
  /** Mission seconds per second of wall time; none is as fast as possible. */
  pace: number | null;
  paused: boolean;
  questions: OpenQuestion[];
  /** A planner at work; mission time stands still meanwhile. */
  planning: { goal: string; since_s: number } | null;
  targets: { id: string; known: boolean }[];
  commands: CommandState[];
}

/** What a person asks of the flight. */
export type Wish =
  | { do: 'pause' | 'resume' | 'step' | 'stop' }
  | { do: 'pace'; pace: number | null }
  | { do: 'answer'; agent: string; question: number; answer: string }
  | { do: 'message'; form: string }
  | { do: 'add-target' | 'remove-target'; target: string }
  | { do: 'value-target'; target: string; value: number }
  | { do: 'acknowledge'; alarm: string };

/** A server that may have a flight under way. */
export class ServedFlight {
  constructor(private readonly base: string) {}

  /** The flight now; null if the server only shows a record. */
  async operation(): Promise<Operation | null> {
    return this.ask<Operation | null>('operation');
  }

  /** Sends a command; the answer comes when it has its end. */
  async command(wish: Wish): Promise<CommandState> {
    return this.ask<CommandState>('commands', {
      method: 'POST',
      headers: { 'Content-Type': 'application/json' },
      body: JSON.stringify(wish),
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
    if (!response.ok) throw new RecordError(body.error ?? response.statusText, body.help ?? '');
    return body;
  }
}
