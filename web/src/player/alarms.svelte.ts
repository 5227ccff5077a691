/** The alarms at the cursor's instant, read while the cursor is still. */

import { type Alarm, alarmsOf } from '../record/alarms';
import { LatestOnly } from '../record/latest';
import type { RecordSource } from '../record/source';
import { isWatchedState, marginsOf } from '../record/states';
import type { AskedQuestion, RecordedCommand, SignalWindow, Trouble } from '../record/types';

/** Number of signals whose excursions are requested at a time. */
const SIGNALS_MAX = 24;
/** Alarms that may be younger than this are not called missing: a live flight advances between two requests. */
const PRESENT_NS = 60e9;
/** Resolution at which the margins of requirements at risk are read. */
const MARGIN_PIXELS = 2000;

export class Alarms {
  windows = $state.raw<SignalWindow[]>([]);
  commands = $state.raw<RecordedCommand[]>([]);
  trouble = $state.raw<string | null>(null);
  /** The instant of the signals and commands; null before the first answer. */
  knownNs = $state.raw<number | null>(null);
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
        const read = async (names: string[], pixels: number): Promise<SignalWindow[]> => {
          if (names.length === 0) return [];
          const query = { names: names.slice(0, SIGNALS_MAX), fromNs: 0, toNs: atNs, atNs, pixels };
          return (await source.samples(query)).windows;
        };
        const namesOf = (some: typeof signals) => some.map(one => one.name);
        const [limits, states] = await Promise.all([
          read(namesOf(watched), 1),
          read(namesOf(signals.filter(isWatchedState)), 1),
        ]);
        const margins = await read(marginsOf(states), MARGIN_PIXELS);
        return { windows: [...limits, ...states, ...margins], commands };
      },
      ({ windows, commands }, atNs) => {
        this.knownNs = atNs;
        this.windows = windows;
        this.commands = commands;
        this.trouble = null;
      },
      error => (this.trouble = error instanceof Error ? error.message : String(error)),
    );
  }

  /** True if the alarms up to an instant, or shortly before it, are known. */
  isKnownAt(atNs: number): boolean {
    return this.knownNs !== null && this.knownNs >= atNs - PRESENT_NS;
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
