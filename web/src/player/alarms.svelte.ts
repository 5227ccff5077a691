/** The alarms at the cursor's instant, read while the cursor is still. */

import { type Alarm, alarmsOf } from '../record/alarms';
import { LatestOnly } from '../record/latest';
import type { RecordSource } from '../record/source';
import type { AskedQuestion, RecordedCommand, SignalWindow, Trouble } from '../record/types';

/** Number of signals whose excursions are requested at a time. */
const SIGNALS_MAX = 24;

export class Alarms {
  windows = $state.raw<SignalWindow[]>([]);
  commands = $state.raw<RecordedCommand[]>([]);
  trouble = $state.raw<string | null>(null);
  private readonly questions: LatestOnly<number, { windows: SignalWindow[]; commands: RecordedCommand[] }>;

  constructor(source: RecordSource) {
    this.questions = new LatestOnly(
      async atNs => {
        const [{ signals }, { commands }] = await Promise.all([
          source.signals(atNs),
          source.commandLog(atNs),
        ]);
        const watched = signals.filter(
          one => one.kind === 'number' && one.limits.some(limit => limit.guarded),
        );
        const names = watched.slice(0, SIGNALS_MAX).map(one => one.name);
        if (names.length === 0) return { windows: [], commands };
        const answer = await source.samples({ names, fromNs: 0, toNs: atNs, atNs, pixels: 1 });
        return { windows: answer.windows, commands };
      },
      ({ windows, commands }) => {
        this.windows = windows;
        this.commands = commands;
        this.trouble = null;
      },
      error => (this.trouble = error instanceof Error ? error.message : String(error)),
    );
  }

  ask(atNs: number): void {
    this.questions.put(atNs);
  }

  list(
    troubles: readonly Trouble[],
    questions: readonly AskedQuestion[],
    atNs: number,
    subject: (trouble: Trouble) => string,
    signalName: (window: SignalWindow) => string,
  ): Alarm[] {
    return alarmsOf(troubles, questions, this.windows, this.commands, atNs, subject, signalName);
  }
}
