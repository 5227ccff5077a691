/**
 * The flight's surroundings at the cursor: all plans so far, the seen ground, wind and link. They are read while the cursor is still;
 * while it moves, the panels draw the part already known by then.
 */

import { LatestOnly } from '../record/latest';
import { airSignals } from '../record/seen';
import type { HoldingsQuery, RecordSource } from '../record/source';
import type { Footprints, Holdings, MissionFacts, Plans, ScoreSoFar, SignalWindow } from '../record/types';

/** Number of pixels along the track at which links and winds are requested. */
const LINK_PIXELS = 800;

export class Scenery {
  plans = $state.raw<Plans>({ plans: [], left_out: 0 });
  /** True once the plans were read. */
  knowsPlans = $state(false);
  footprints = $state.raw<Footprints | null>(null);
  wind = $state.raw<SignalWindow[]>([]);
  links = $state.raw<SignalWindow[]>([]);
  facts = $state.raw<MissionFacts | null>(null);
  holdings = $state.raw<Holdings | null>(null);
  /** The score with its instant; null while none is known. */
  score = $state.raw<{ atNs: number; score: ScoreSoFar } | null>(null);
  /** The error of the last request, in one sentence, for the map. */
  trouble = $state<string | null>(null);
  private readonly questions: LatestOnly<number, void>;
  private readonly planQuestions: LatestOnly<number, Plans>;
  private readonly holdingQuestions: LatestOnly<HoldingsQuery, Holdings>;
  private readonly scoreQuestions: LatestOnly<number, ScoreSoFar | null>;

  /** `onPlans` is called with the instant of the plans that are shown from then on. */
  constructor(
    private readonly source: RecordSource,
    onPlans: (atNs: number) => void = () => undefined,
  ) {
    const fail = (error: unknown) => {
      this.trouble = String(error instanceof Error ? error.message : error);
    };
    this.questions = new LatestOnly(
      atNs => this.read(atNs),
      () => {
        this.trouble = null;
      },
      fail,
    );
    this.planQuestions = new LatestOnly(
      atNs => source.plans(atNs),
      (plans, atNs) => {
        this.plans = plans;
        this.knowsPlans = true;
        onPlans(atNs);
      },
      fail,
    );
    this.scoreQuestions = new LatestOnly(
      atNs => source.score(atNs),
      (score, atNs) => {
        this.score = score === null ? null : { atNs, score };
      },
      fail,
    );
    this.holdingQuestions = new LatestOnly(
      query => source.holdings(query),
      holdings => {
        this.holdings = holdings;
      },
      fail,
    );
  }

  /** Requests the score. It depends on the instant, so it is requested while the cursor moves, too. */
  askScore(atNs: number): void {
    this.scoreQuestions.put(atNs);
  }

  /** Requests the holders of resources, for panels that show them. */
  askHoldings(query: HoldingsQuery): void {
    this.holdingQuestions.put(query);
  }

  /** Requests the plans. They depend on the instant, so they are requested while the cursor moves, too. */
  askPlans(atNs: number): void {
    this.planQuestions.put(atNs);
  }

  /** Requests the other data once the cursor is still. */
  ask(atNs: number): void {
    this.questions.put(atNs);
  }

  /** Reads the facts of the mission, which never change. */
  async readFacts(): Promise<void> {
    try {
      this.facts = await this.source.facts();
    } catch (error) {
      this.trouble = String(error instanceof Error ? error.message : error);
    }
  }

  private async read(atNs: number): Promise<void> {
    const [footprints, { signals }] = await Promise.all([
      this.source.footprints(atNs),
      this.source.signals(atNs),
    ]);
    this.footprints = footprints;
    const { wind, links } = airSignals(signals);
    const windows = async (names: string[], pixels: number) =>
      names.length === 0
        ? []
        : (await this.source.samples({ names, fromNs: 0, toNs: atNs, atNs, pixels })).windows;
    [this.wind, this.links] = await Promise.all([
      windows(wind ?? [], LINK_PIXELS),
      windows(
        links.filter(link => link.limits.some(limit => limit.low !== null)).map(link => link.name),
        LINK_PIXELS,
      ),
    ]);
  }
}
