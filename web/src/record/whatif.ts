/** Records next to the one that is shown, forks of it, and drafts of plans: what the server makes at the user's wish. */

import { RecordError } from './source';
import type { PlanInForce } from './types';

/** An agent of a record that the page can show. */
export interface ShelfRow {
  /** 0 is the record that the server was started with. */
  id: number;
  record: string;
  agent: string;
  mission: string | null;
  /** Changes of a fork, and the instant of the first. */
  fork: { at_ns: number; with: string } | null;
}

/** A flight continued with changes. */
export interface ForkState {
  id: number;
  at_ns: number;
  with: string;
  file: string;
  state: 'flying' | 'ended' | 'failed';
  now_ns: number;
  /** Its number on the shelf, once it has ended. */
  record: number | null;
  /** Both reports side by side. */
  comparison: string | null;
  failure: { message: string; reason: string | null; help: string | null } | null;
}

export interface ForkRequest {
  at_ns: number;
  wind_factor: number | null;
  seed: number | null;
  plan: string[];
  inputs: { t: number; event: string }[];
}

/** A draft with the checker's word: a plan, or what is wrong and at which visit. */
export interface DraftAnswer {
  at_ns: number;
  plan: PlanInForce | null;
  worth: { what: string; value: number } | null;
  violation: { reason: string; visit: number | null } | null;
}

/** The server's part in what-if. */
export class Workshop {
  constructor(private readonly base: string) {}

  records = async (): Promise<ShelfRow[]> => (await this.ask<{ records: ShelfRow[] }>('records')).records;
  forks = (): Promise<ForkState[]> => this.ask('forks');
  fork = (request: ForkRequest): Promise<ForkState> => this.ask('forks', request);
  stop = (id: number): Promise<ForkState> => this.ask(`forks/${id}/stop`, {});
  draft = (visits: string[], atNs: number | null): Promise<DraftAnswer> =>
    this.ask('drafts', { visits, at_ns: atNs === null ? null : Math.round(atNs) });

  private async ask<T>(what: string, body?: object): Promise<T> {
    const init = body && {
      method: 'POST',
      headers: { 'Content-Type': 'application/json' },
      body: JSON.stringify(body),
    };
    let response: Response;
    try {
      response = await fetch(`${this.base}/api/${what}`, init);
    } catch {
      throw new RecordError('the server does not answer', 'is `apex serve` still running?');
    }
    const answer = await response.json();
    if (!response.ok) throw new RecordError(answer.error ?? response.statusText, answer.help ?? '');
    return answer;
  }
}
