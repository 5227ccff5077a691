/** Records for comparison, forks of the shown record, and drafts of plans: data that the server makes on the user's demand. */

import { RecordError } from './source';
import type { DraftAnswer, ForkRequest, ForkState, ShelfRow } from './types';

/** The requests of what-if to the server. */
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
    if (!response.ok) throw RecordError.of(response, answer);
    return answer;
  }
}
