/** Another record for comparison with the shown one, at the same instant: a fork, another agent, another flight. */

import { LatestOnly } from '../record/latest';
import type { RecordSource } from '../record/source';
import type { Mission, PlanInForce, Target, Track } from '../record/types';

interface OtherMoment {
  mission: Mission;
  targets: Target[];
  plan: PlanInForce | null;
}

export class Other {
  id = $state.raw<number | null>(null);
  mission = $state.raw<Mission | null>(null);
  targets = $state.raw<Target[]>([]);
  plan = $state.raw<PlanInForce | null>(null);
  track = $state.raw<Track | null>(null);
  trouble = $state.raw<string | null>(null);
  source: RecordSource | null = null;
  private questions: LatestOnly<number, OtherMoment> | null = null;

  /** Opens a record; `onMissing` is called with the reason if it cannot be read. */
  open(
    source: RecordSource | null,
    id: number | null,
    onMissing: (reason: string) => void = () => undefined,
  ): void {
    if (id === this.id) return;
    this.id = id;
    this.source = source;
    this.mission = this.plan = this.track = this.trouble = null;
    this.targets = [];
    this.questions = null;
    if (!source) return;
    const fail = (error: unknown) => {
      if (this.source === source) this.trouble = error instanceof Error ? error.message : String(error);
    };
    this.questions = new LatestOnly(
      atNs => momentOf(source, atNs),
      moment => {
        if (this.source !== source) return;
        this.mission = moment.mission;
        this.targets = moment.targets;
        this.plan = moment.plan;
      },
      fail,
    );
    source.track().then(
      track => {
        if (this.source === source) this.track = track;
      },
      error => {
        fail(error);
        if (this.source === source && this.trouble) onMissing(this.trouble);
      },
    );
  }

  ask(atNs: number): void {
    this.questions?.put(atNs);
  }
}

async function momentOf(source: RecordSource, atNs: number): Promise<OtherMoment> {
  const [mission, targets, plan] = await Promise.all([
    source.mission(atNs),
    source.targets(atNs),
    source.plan(atNs),
  ]);
  return { mission, targets, plan };
}
