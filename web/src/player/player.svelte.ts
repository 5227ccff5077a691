/**
 * The Player: one cursor over one record, live or finished.
 *
 * It owns the cursor, what is played and what is selected. It owns no truth about the flight: the panels ask the
 * record for the cursor's instant. A growing record only moves the end.
 */

import { LatestOnly } from '../record/latest';
import { RecordError, type RecordSource } from '../record/source';
import type {
  Growth,
  Mission,
  Report,
  Target,
  TaskExplanation,
  Tasks,
  Timeline,
  Track,
} from '../record/types';
import { advance, clamp, otherSpeed, type Range, shift, speedFor, stepNs, zoom } from './clock';

/** A growing record is read again at most this often; drawing all of it is the dear part. */
const REREAD_MS = 1500;
/** A full explanation restores an instant: it is asked for when the cursor has rested this long. */
const REST_MS = 250;

export class Player {
  mission = $state.raw<Mission | null>(null);
  track = $state.raw<Track | null>(null);
  timeline = $state.raw<Timeline | null>(null);
  targets = $state.raw<Target[]>([]);
  report = $state.raw<Report | null>(null);
  tasks = $state.raw<Tasks | null>(null);
  why = $state.raw<TaskExplanation | null>(null);
  whyTrouble = $state<string | null>(null);

  atNs = $state(0);
  visible = $state.raw<Range>({ fromNs: 0, toNs: 0 });
  playing = $state(false);
  speed = $state(1);
  /** The cursor stays at the end of a growing record. */
  following = $state(false);
  connected = $state(true);
  trouble = $state<{ error: string; help: string } | null>(null);

  selectedTask = $state<number | null>(null);
  selectedTarget = $state<string | null>(null);
  showEnded = $state(true);
  find = $state('');

  /** Until the user chooses a speed, it fits the record's length. */
  private speedChosen = false;
  private growth: Growth | null = null;
  private readAt = 0;
  private rereadTimer: ReturnType<typeof setTimeout> | undefined;
  private restTimer: ReturnType<typeof setTimeout> | undefined;
  private frame = 0;
  private stopWatching: (() => void) | undefined;
  private readonly taskQuestions: LatestOnly<Parameters<RecordSource['tasks']>[0], Tasks>;
  private readonly whyQuestions: LatestOnly<
    { task: number; atNs: number; explain: boolean },
    TaskExplanation
  >;

  constructor(readonly source: RecordSource) {
    this.taskQuestions = new LatestOnly(
      question => source.tasks(question),
      answer => {
        this.tasks = answer;
        this.trouble = null;
      },
      error => this.showError(error),
    );
    this.whyQuestions = new LatestOnly(
      question => source.why(question.task, question.atNs, question.explain),
      (answer, question) => {
        if (question.task !== this.selectedTask) return;
        this.why = answer;
        this.whyTrouble = null;
      },
      error => {
        this.why = null;
        this.whyTrouble = error instanceof RecordError ? `${error.message}; ${error.help}` : String(error);
      },
    );
  }

  get range(): Range {
    return { fromNs: this.mission?.from_ns ?? 0, toNs: this.mission?.end_ns ?? 0 };
  }

  get live(): boolean {
    return this.mission?.status === 'live';
  }

  /** Reads the record and begins to watch it grow. */
  async open(): Promise<void> {
    try {
      await this.read();
    } catch (error) {
      this.showError(error);
      setTimeout(() => void this.open(), REREAD_MS);
      return;
    }
    this.trouble = null;
    const mission = this.mission;
    if (!mission) return;
    this.visible = this.range;
    this.speed = speedFor(this.range);
    this.following = mission.status === 'live';
    this.seek(this.following ? mission.end_ns : mission.from_ns, this.following);
    if (mission.status !== 'complete') {
      this.stopWatching = this.source.watch(
        growth => this.grow(growth),
        connected => {
          this.connected = connected;
        },
      );
    }
  }

  /** Ends all timers and connections. */
  close(): void {
    this.pause();
    clearTimeout(this.rereadTimer);
    clearTimeout(this.restTimer);
    this.stopWatching?.();
  }

  /** Moves the cursor; by hand, it lets go of the end of a growing record. */
  seek(atNs: number, following = false): void {
    this.atNs = clamp(atNs, this.range);
    this.following = following && this.live;
    this.ask();
  }

  /** Moves the cursor by a step of the arrow keys. */
  step(direction: 1 | -1, coarse: boolean): void {
    this.seek(this.atNs + direction * stepNs(this.visible, coarse));
    this.reveal();
  }

  follow(): void {
    this.pause();
    this.seek(this.range.toNs, true);
    this.reveal();
  }

  toggle(): void {
    if (this.playing) this.pause();
    else this.play();
  }

  play(): void {
    if (this.playing) return;
    if (this.atNs >= this.range.toNs && !this.live) this.seek(this.range.fromNs);
    this.playing = true;
    let before = performance.now();
    const next = (now: number) => {
      const moved = advance(this.atNs, now - before, this.speed, this.range);
      before = now;
      this.atNs = moved.atNs;
      this.ask();
      if (moved.ended) {
        this.pause();
        this.following = this.live;
        return;
      }
      this.reveal();
      this.frame = requestAnimationFrame(next);
    };
    this.frame = requestAnimationFrame(next);
  }

  pause(): void {
    this.playing = false;
    cancelAnimationFrame(this.frame);
  }

  changeSpeed(direction: 1 | -1): void {
    this.speed = otherSpeed(this.speed, direction);
    this.speedChosen = true;
  }

  zoomAt(atNs: number, factor: number): void {
    this.visible = zoom(this.visible, this.range, atNs, factor);
  }

  pan(byNs: number): void {
    this.visible = shift(this.visible, this.range, byNs);
  }

  showAll(): void {
    this.visible = this.range;
  }

  select(task: number | null): void {
    this.selectedTask = task;
    this.why = null;
    this.whyTrouble = null;
    this.ask();
  }

  setFind(find: string): void {
    this.find = find;
    this.ask();
  }

  setShowEnded(showEnded: boolean): void {
    this.showEnded = showEnded;
    this.ask();
  }

  private ask(): void {
    if (!this.mission) return;
    this.taskQuestions.put({
      atNs: this.atNs,
      ended: this.showEnded,
      find: this.find.trim(),
      with: this.selectedTask,
    });
    const task = this.selectedTask;
    clearTimeout(this.restTimer);
    if (task === null) return;
    this.whyQuestions.put({ task, atNs: this.atNs, explain: false });
    const explain = () => this.whyQuestions.put({ task, atNs: this.atNs, explain: true });
    this.restTimer = setTimeout(explain, REST_MS);
  }

  private reveal(): void {
    const { fromNs, toNs } = this.visible;
    if (this.atNs < fromNs || this.atNs > toNs) this.pan(this.atNs - (fromNs + toNs) / 2);
  }

  private grow(growth: Growth): void {
    const before = this.growth;
    this.growth = growth;
    if (before && before.end_ns === growth.end_ns && before.status === growth.status) return;
    clearTimeout(this.rereadTimer);
    const wait = Math.max(0, this.readAt + REREAD_MS - performance.now());
    this.rereadTimer = setTimeout(() => void this.reread(), wait);
  }

  private async reread(): Promise<void> {
    const sawAll = this.visible.toNs >= this.range.toNs;
    try {
      await this.read();
    } catch (error) {
      this.showError(error);
      return;
    }
    this.trouble = null;
    if (sawAll) this.visible = { fromNs: this.visible.fromNs, toNs: this.range.toNs };
    if (!this.speedChosen && !this.playing) this.speed = speedFor(this.range);
    if (this.following) this.seek(this.range.toNs, true);
    else this.ask();
  }

  private async read(): Promise<void> {
    this.readAt = performance.now();
    const { source } = this;
    const mission = await source.mission();
    const [track, timeline, targets, report] = await Promise.all([
      source.track(),
      source.timeline(),
      source.targets(),
      source.report(),
    ]);
    this.track = track;
    this.timeline = timeline;
    this.targets = targets;
    this.report = report;
    this.mission = mission;
  }

  private showError(error: unknown): void {
    this.trouble =
      error instanceof RecordError
        ? { error: error.message, help: error.help }
        : { error: String(error), help: 'reload the page' };
  }
}
