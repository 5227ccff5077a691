/** The flight under way behind a record: its state for an operator, and commands to it. */

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

/** An operator or program that speaks to the flight. */
export interface Actor {
  name: string;
  role: string;
}

/** Authority over the flight: its holder, the offer of it, and the rights of the caller. */
export interface Authority {
  /** Grows with every change of the holder. */
  epoch: number;
  holder: Actor | null;
  /** The holder was not heard for long: another operator may take authority. */
  silent: boolean;
  offer: { to: string; left_s: number } | null;
  you: Actor;
  yours: boolean;
  may_take: boolean;
  /** Other callers with a recent request that may hold it. */
  stations: Actor[];
}

/** A command and its end: exactly one of accepted, rejected and expired. */
export interface CommandState {
  number: number;
  words: string;
  /** The name of its author. */
  by: string;
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
  authority: Authority;
}

/** What an operator asks of the flight. */
export type Wish =
  | { do: 'pause' | 'resume' | 'step' | 'stop' }
  | { do: 'pace'; pace: number | null }
  | { do: 'answer'; agent: string; question: number; answer: string }
  | { do: 'message'; form: string }
  | { do: 'add-target' | 'remove-target'; target: string }
  | { do: 'value-target'; target: string; value: number }
  | { do: 'acknowledge'; alarm: string }
  | { do: 'take-authority' | 'refuse-authority' | 'release-authority' }
  | { do: 'offer-authority'; to: string };

/** A server that may have a flight under way. */
export class ServedFlight {
  constructor(private readonly base: string) {}

  /** The flight now; null if the server only shows a record. */
  async operation(): Promise<Operation | null> {
    return this.ask<Operation | null>('operation');
  }

  /** Sends a command, in an epoch of authority if one is stated; the answer comes when it has its end. */
  async command(wish: Wish, epoch: number | null): Promise<CommandState> {
    return this.ask<CommandState>('commands', {
      method: 'POST',
      headers: { 'Content-Type': 'application/json' },
      body: JSON.stringify({ ...wish, epoch }),
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
