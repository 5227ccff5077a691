/**
 * The Player: one cursor over one record, live or finished.
 *
 * It holds the cursor, the playback and the selection, but no facts about the flight: the panels request those from the record for the
 * cursor's instant. While a record grows, only the end moves.
 */

import type { Alarm } from '../record/alarms';
import { targetsWithoutEndedVisits } from '../record/ended';
import { keptNames } from '../record/kept';
import { LatestOnly } from '../record/latest';
import type { MeasuredWind, Present } from '../record/measured';
import {
  failureOf,
  RecordError,
  type RecordSource,
  ServedRecord,
  type TimelineQuery,
} from '../record/source';
import type {
  AskedQuestion,
  Growth,
  Mission,
  PlanInForce,
  Report,
  Surroundings,
  Target,
  TaskExplanation,
  Tasks,
  Timeline,
  Track,
  Trouble,
} from '../record/types';
import { missionTime } from '../time/format';
import type { Names } from '../words/phrase';
import { signalWords, subjectWords } from '../words/subject';
import { type Address, type Rows, type Selection, selectionText } from './address';
import { Alarms } from './alarms.svelte';
import {
  advance,
  axisOf,
  clamp,
  hasGrown,
  otherSpeed,
  Pace,
  type Range,
  shift,
  speedFor,
  stepNs,
  zoom,
} from './clock';
import { Desk } from './desk.svelte';
import { type Failure, Freshness } from './freshness.svelte';
import type { Panel } from './layout';
import { Other } from './other.svelte';
import { Scenery } from './scenery.svelte';
import { foundSelection } from './selected';

/** A growing record is read again at most this often, because drawing all of it takes long. */
const REREAD_MS = 1500;
/** Time after the last move of the cursor at which it counts as still, if the answers for its instant have arrived. */
const STILL_MS = 600;
/** A full explanation requires a restored instant, so it is requested only after the cursor has been still for this long. */
const REST_MS = 250;

/** The facts about the flight as a whole that are known at an instant. */
interface Moment {
  mission: Mission;
  targets: Target[];
  plan: PlanInForce | null;
  troubles: Trouble[];
  questions: AskedQuestion[];
  report: Report;
  present: Present;
}

export class Player {
  mission = $state.raw<Mission | null>(null);
  track = $state.raw<Track | null>(null);
  /** All samples shortly before the cursor's instant; `track` has only a part of the samples. */
  tail = $state.raw<Track | null>(null);
  /** The last measured wind. */
  wind = $state.raw<MeasuredWind | null>(null);
  timeline = $state.raw<Timeline | null>(null);
  targets = $state.raw<Target[]>([]);
  surroundings = $state.raw<Surroundings>({ zones: [], landing_places: [] });
  plan = $state.raw<PlanInForce | null>(null);
  troubles = $state.raw<Trouble[]>([]);
  /** Questions to operators by the cursor's instant. */
  questions = $state.raw<AskedQuestion[]>([]);
  report = $state.raw<Report | null>(null);
  tasks = $state.raw<Tasks | null>(null);
  why = $state.raw<TaskExplanation | null>(null);
  whyTrouble = $state<string | null>(null);

  /** Plans, the ground seen, wind and link. */
  readonly scenery: Scenery;

  atNs = $state(0);
  /** True from a move of the cursor until it has been still for a while and the answers for its instant are shown. */
  moving = $state(false);
  /** Counts the readings of a growing record. Panels that read on their own read again: the facts of an instant change in a pause. */
  revision = $state(0);
  visible = $state.raw<Range>({ fromNs: 0, toNs: 0 });
  playing = $state(false);
  speed = $state(1);
  /** True if the cursor stays at the end of a growing record. */
  following = $state(false);
  connected = $state(true);
  /** Whether all that is shown belongs to the cursor's instant. */
  readonly freshness = new Freshness();
  /** Sentences about parts of the address that this record cannot show. */
  faults = $state.raw<string[]>([]);

  selection = $state.raw<Selection>(null);
  /** Plotted signals by name without parentheses; null means the default choice (`chosenSignals`). */
  strips = $state.raw<string[] | null>(null);
  /** The selected stretch of time. */
  span = $state.raw<Range | null>(null);
  /** The rows of the timeline. */
  rows = $state.raw<Rows>('all');
  /** The place of each panel. */
  readonly desk = new Desk();
  /** The place in the program requested by the user. */
  shownPlace = $state.raw<string | null>(null);
  readonly alarms: Alarms;
  /** The record in the comparison with this one. */
  readonly other = new Other();
  /** Visits that the user draws, by target; null while none is drawn. */
  draft = $state.raw<string[] | null>(null);
  /** The visit of the draft that cannot be made, and the plan if all can. */
  draftFault = $state.raw<number | null>(null);
  draftPlan = $state.raw<PlanInForce | null>(null);
  showEnded = $state(true);
  find = $state('');

  /** True once the user has chosen a speed; before that, the speed follows the record's length. */
  private speedChosen = false;
  private growth: Growth | null = null;
  private readAt = 0;
  /** The browser's time of the last growth of a live record, in milliseconds. */
  updatedMs = 0;
  private rereadTimer: ReturnType<typeof setTimeout> | undefined;
  private sceneryTimer: ReturnType<typeof setTimeout> | undefined;
  private restTimer: ReturnType<typeof setTimeout> | undefined;
  private stillTimer: ReturnType<typeof setTimeout> | undefined;
  private frame = 0;
  private stopWatching: (() => void) | undefined;
  /** Width of the timeline's drawing. */
  private pixels = 1000;
  private readonly momentQuestions: LatestOnly<number, Moment>;
  private readonly laneQuestions: LatestOnly<TimelineQuery, Timeline>;
  private readonly taskQuestions: LatestOnly<Parameters<RecordSource['tasks']>[0], Tasks>;
  private readonly whyQuestions: LatestOnly<
    { task: number; atNs: number; explain: boolean },
    TaskExplanation
  >;

  /** The names of targets by identifier. */
  readonly names: Names = $derived.by(() => {
    this.namesBefore = keptNames(this.namesBefore, this.targets);
    return this.namesBefore;
  });
  private namesBefore: Names = new Map();
  /** The alarms of the cursor's instant. */
  readonly alarmList: Alarm[] = $derived.by(() =>
    this.alarms.list(
      this.troubles,
      this.questions,
      this.atNs,
      trouble => subjectWords(trouble.subject, this.names),
      window => signalWords(window.attribute),
    ),
  );

  constructor(readonly source: RecordSource & Partial<Pick<ServedRecord, 'base' | 'id'>>) {
    this.scenery = new Scenery(source, atNs => this.freshness.answer('plans', atNs));
    this.alarms = new Alarms(source);
    this.taskQuestions = new LatestOnly(
      question => source.tasks(question),
      (answer, { atNs }) => {
        this.tasks = answer;
        this.freshness.answer('tasks', atNs);
      },
      error => this.showError('tasks', error),
    );
    this.momentQuestions = new LatestOnly(
      atNs => this.momentAt(atNs),
      (moment, atNs) => this.show(moment, atNs),
      error => this.showError('flight', error),
    );
    this.laneQuestions = new LatestOnly(
      question => source.timeline(question),
      (answer, { atNs }) => {
        this.timeline = answer;
        this.freshness.answer('timeline', atNs);
      },
      error => this.showError('timeline', error),
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

  /** The span of the time axis. */
  get axis(): Range {
    return axisOf(this.range, this.scenery.facts?.duration_ns ?? null, this.atNs);
  }

  /** True if the window is the whole axis. */
  private get showsAll(): boolean {
    return this.visible.fromNs <= this.axis.fromNs && this.visible.toNs >= this.axis.toNs;
  }

  /** The panel on top of the right slot; null means the default: the log, or the explanation once a task is selected. */
  get tab(): Panel | null {
    return this.desk.top.right;
  }

  set tab(panel: Panel | null) {
    if (panel) this.desk.show(panel);
    else this.desk.top = { ...this.desk.top, right: null };
  }

  get live(): boolean {
    return this.mission?.status === 'live';
  }

  get selectedTask(): number | null {
    return this.selection && 'task' in this.selection ? this.selection.task : null;
  }

  get selectedTarget(): string | null {
    return this.selection && 'target' in this.selection ? this.selection.target : null;
  }

  get selectedEvent(): number | null {
    return this.selection && 'event' in this.selection ? this.selection.event : null;
  }

  get selectedPlan(): number | null {
    return this.selection && 'plan' in this.selection ? this.selection.plan : null;
  }

  /** Opens the record in the state of an address, and begins to watch its growth. */
  async open(address: Address | null = null): Promise<void> {
    try {
      const { from_ns, end_ns, status } = await this.source.mission(null);
      const live = status === 'live';
      const asked = address?.atNs === 'live' || address?.atNs == null ? null : address.atNs;
      this.growth = { end_ns, status, batches: 0 };
      if (asked !== null && (asked < from_ns || asked > end_ns))
        this.faults = [outside(asked, from_ns, end_ns)];
      this.atNs = clamp(asked ?? (live ? end_ns : from_ns), { fromNs: from_ns, toNs: end_ns });
      this.freshness.ask(this.atNs);
      this.following = live && asked === null;
      this.selection = address?.selection ?? null;
      // Shown at once: a key between two parts of the opening would be undone by the rest of it.
      await this.read(this.scenery.readFacts());
    } catch (error) {
      this.showError('flight', error);
      setTimeout(() => void this.open(address), REREAD_MS);
      return;
    }
    const mission = this.mission;
    if (!mission) return;
    this.visible = this.axis;
    const target = this.selectedTarget;
    if (target !== null && !this.targets.some(one => one.id === target))
      this.faults = [
        ...this.faults,
        `The address has sel=target:${target}; no such target is known by this time.`,
      ];
    const readNs = this.atNs;
    if (address) {
      this.take(address);
      await this.goToSelection(address);
    }
    this.speed = speedFor(this.range);
    // The facts of this instant have just been read.
    if (this.atNs !== readNs) this.momentQuestions.put(this.atNs);
    this.askParts();
    if (mission.status !== 'complete') {
      this.updatedMs = performance.now();
      this.stopWatching = this.source.watch(
        growth => this.grow(growth),
        connected => {
          this.connected = connected;
        },
      );
    }
  }

  /** Moves the cursor to the event or the plan of an address without an instant; a number that the record does not have is a fault. */
  private async goToSelection({ selection, atNs }: Address): Promise<void> {
    try {
      const found = await foundSelection(this.source, selection, this.range.toNs);
      if ('missing' in found)
        this.faults = [...this.faults, `The address has sel=${selectionText(selection)}; ${found.missing}.`];
      else if (atNs === null && found.atNs !== null) {
        this.moveTo(clamp(found.atNs, this.range));
        this.following = false;
      }
      this.freshness.succeed('selection');
    } catch (error) {
      this.showError('selection', error);
    }
  }

  /** The state as an address, without values that are as at first. */
  get address(): Omit<Address, 'theme'> {
    const first = this.atNs === this.range.fromNs && !this.live;
    return {
      atNs: this.following ? (this.live ? null : this.atNs) : first ? null : this.atNs,
      window: this.showsAll ? null : this.visible,
      selection: this.selection,
      strips: this.strips,
      span: this.span,
      tab: this.tab,
      left: this.desk.top.left,
      layout: this.desk.text,
      record: this.source.id || null,
      versus: this.other.id,
      rows: this.rows,
    };
  }

  /** Takes over the state of an address, and requests its data. */
  apply(address: Address): void {
    this.take(address);
    this.ask();
  }

  private take(address: Address): void {
    const { window, selection, atNs } = address;
    this.visible = window ? shift(window, this.axis, 0) : this.axis;
    if (JSON.stringify(selection) !== JSON.stringify(this.selection)) this.why = null;
    this.selection = selection;
    this.strips = address.strips;
    this.span = address.span;
    this.desk.open(address.layout);
    this.desk.top = { left: address.left, right: address.tab };
    this.compareWith(address.versus);
    this.rows = address.rows ?? 'all';
    const isEnd = atNs === 'live' || (atNs === null && this.live);
    this.moveTo(clamp(isEnd ? this.range.toNs : (atNs ?? this.range.fromNs), this.range));
    this.following = isEnd && this.live;
  }

  /** Ends all timers and connections. */
  close(): void {
    this.pause();
    clearTimeout(this.rereadTimer);
    clearTimeout(this.restTimer);
    clearTimeout(this.stillTimer);
    clearTimeout(this.sceneryTimer);
    this.freshness.stop();
    this.stopWatching?.();
  }

  /** Moves the cursor. A move by hand ends the following of a growing record. */
  seek(atNs: number, following = false): void {
    this.moveTo(clamp(atNs, this.range));
    this.following = following && this.live;
    this.ask();
  }

  /** Moves the cursor; a window that is the whole axis remains so. */
  private moveTo(atNs: number): void {
    const showsAll = this.showsAll;
    this.atNs = atNs;
    this.moving = true;
    clearTimeout(this.stillTimer);
    this.stillTimer = setTimeout(() => this.rest(), STILL_MS);
    if (showsAll && this.visible.toNs !== this.axis.toNs) this.visible = this.axis;
  }

  private rest(): void {
    if (this.freshness.isCurrent) this.moving = false;
    else this.stillTimer = setTimeout(() => this.rest(), STILL_MS);
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
    this.freshness.play(true);
    const pace = new Pace(performance.now());
    const next = (now: number) => {
      const elapsedMs = pace.due(now);
      if (elapsedMs === null) {
        this.frame = requestAnimationFrame(next);
        return;
      }
      const moved = advance(this.atNs, elapsedMs, this.speed, this.range);
      this.moveTo(moved.atNs);
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
    this.freshness.play(false);
    cancelAnimationFrame(this.frame);
  }

  changeSpeed(direction: 1 | -1): void {
    this.speed = otherSpeed(this.speed, direction);
    this.speedChosen = true;
  }

  zoomAt(atNs: number, factor: number): void {
    this.visible = zoom(this.visible, this.axis, atNs, factor);
    this.askLanes();
  }

  pan(byNs: number): void {
    this.visible = shift(this.visible, this.axis, byNs);
    this.askLanes();
  }

  /** Shows a window of time. */
  showWindow(range: Range): void {
    this.visible = shift(range, this.axis, 0);
    this.askLanes();
  }

  showAll(): void {
    this.visible = this.axis;
    this.askLanes();
  }

  /** The timeline is drawn with this width. */
  setPixels(pixels: number): void {
    const rounded = Math.max(100, Math.round(pixels));
    if (rounded === this.pixels) return;
    this.pixels = rounded;
    this.askLanes();
  }

  select(task: number | null): void {
    if (task !== null) this.desk.show('why');
    this.choose(task === null ? null : { task });
  }

  /** Selects a task and leaves the panels as they are. */
  selectTaskOnly(task: number): void {
    this.shownPlace = null;
    this.choose({ task });
  }

  /** Shows a place of the program. */
  showPlace(place: string): void {
    this.shownPlace = place;
    this.desk.show('program');
  }

  /** Shows another record, or another agent of this one, at the same instant. */
  showRecord(id: number): void {
    const parameters = new URLSearchParams(window.location.search);
    if (id === 0) parameters.delete('rec');
    else parameters.set('rec', String(id));
    for (const own of ['sel', 'strips', 'vs']) parameters.delete(own);
    parameters.set('t', String(this.atNs / 1e9));
    window.location.assign(`${window.location.pathname}?${parameters}`);
  }

  selectTarget(target: string | null): void {
    this.choose(target === null ? null : { target });
  }

  /** Selects an event of the log, and moves the cursor to its instant. */
  selectEvent(event: number, atNs: number): void {
    this.desk.show('log');
    this.goTo({ event }, atNs);
  }

  /** Selects a plan, and leaves the cursor where it is. */
  selectPlan(plan: number): void {
    this.desk.show('plans');
    this.choose({ plan });
  }

  private goTo(selection: Selection, atNs: number): void {
    this.pause();
    this.selection = selection;
    this.why = null;
    this.whyTrouble = null;
    this.seek(atNs);
    this.reveal();
  }

  /** Compares with the record of this number; null compares no longer. */
  compareWith(id: number | null): void {
    const missing = (reason: string) => {
      this.faults = [...this.faults, `The address has vs=${id}; ${reason}.`];
    };
    this.other.open(id === null ? null : new ServedRecord(this.source.base ?? '', id), id, missing);
    if (id !== null) this.other.ask(this.atNs);
  }

  /** Adds a target to the draft as its last visit, or removes it. */
  toggleVisit(target: string): void {
    const draft = this.draft ?? [];
    this.setDraft(draft.includes(target) ? draft.filter(one => one !== target) : [...draft, target]);
  }

  setDraft(draft: string[] | null): void {
    this.draft = draft;
    this.draftFault = null;
    this.draftPlan = null;
  }

  private choose(selection: Selection): void {
    this.selection = selection;
    this.why = null;
    this.whyTrouble = null;
    this.ask();
  }

  /** Moves the cursor to the next (1) or previous (-1) failure or fault known at the cursor, and selects its subject. */
  goToTrouble(direction: 1 | -1): void {
    const before = this.troubles.filter(trouble => trouble.t_ns < this.atNs);
    const trouble = direction < 0 ? before.at(-1) : undefined;
    if (trouble) this.showTrouble(trouble);
    else if (direction > 0) void this.goToLaterTrouble();
  }

  /** Moves the cursor to a failure or fault and selects its subject. */
  showTrouble(trouble: Pick<Trouble, 't_ns' | 'task' | 'target'>): void {
    const { task, target } = trouble;
    this.goTo(task !== null ? { task } : target ? { target } : null, trouble.t_ns);
  }

  /** Moves to the next failure or fault. Only here the page asks for failures after the cursor's instant, because the user wants to go
   * there. */
  private async goToLaterTrouble(): Promise<void> {
    try {
      const { troubles } = await this.source.troubles(this.range.toNs);
      this.freshness.succeed('later errors');
      const next = troubles.find(trouble => trouble.t_ns > this.atNs);
      if (next) this.showTrouble(next);
    } catch (error) {
      this.showError('later errors', error);
    }
  }

  setFind(find: string): void {
    this.find = find;
    this.ask();
  }

  setShowEnded(showEnded: boolean): void {
    this.showEnded = showEnded;
    this.ask();
  }

  private askLanes(): void {
    if (!this.mission) return;
    const { fromNs, toNs } = this.visible;
    this.laneQuestions.put({ fromNs, toNs, atNs: this.atNs, pixels: this.pixels, with: this.selectedTask });
  }

  /** The failure to show: that of one subject. */
  get trouble(): Failure | null {
    return this.freshness.failures.values().next().value ?? null;
  }

  /** Requests everything about the cursor's instant again. */
  retry(): void {
    this.ask();
  }

  private ask(): void {
    if (!this.mission) return;
    this.momentQuestions.put(this.atNs);
    this.askParts();
  }

  /** Requests what parts of the page show of the instant, without the facts about the flight as a whole. */
  private askParts(): void {
    this.freshness.ask(this.atNs);
    this.askLanes();
    this.taskQuestions.put({
      atNs: this.atNs,
      ended: this.showEnded,
      find: this.find.trim(),
      with: this.selectedTask,
    });
    const task = this.selectedTask;
    this.scenery.askPlans(this.atNs);
    this.scenery.askScore(this.atNs);
    this.other.ask(this.atNs);
    clearTimeout(this.sceneryTimer);
    this.sceneryTimer = setTimeout(() => {
      this.scenery.ask(this.atNs);
      this.alarms.ask(this.atNs);
    }, REST_MS);
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
    this.updatedMs = performance.now();
    const before = this.growth;
    this.growth = growth;
    if (before && !hasGrown(before, growth)) return;
    clearTimeout(this.rereadTimer);
    const wait = Math.max(0, this.readAt + REREAD_MS - performance.now());
    this.rereadTimer = setTimeout(() => void this.reread(), wait);
  }

  private async reread(): Promise<void> {
    const sawAll = this.visible.toNs >= this.axis.toNs;
    try {
      await this.read();
    } catch (error) {
      this.showError('flight', error);
      return;
    }
    this.revision += 1;
    if (sawAll) this.visible = { fromNs: this.visible.fromNs, toNs: this.axis.toNs };
    if (!this.speedChosen && !this.playing) this.speed = speedFor(this.range);
    if (this.following) this.seek(this.range.toNs, true);
    else this.ask();
  }

  /** Reads the record at the cursor's instant, and shows it when `others` have been read, too. */
  private async read(others: Promise<void> | null = null): Promise<void> {
    this.readAt = performance.now();
    const { atNs } = this;
    const [track, moment, surroundings] = await Promise.all([
      this.source.track(),
      this.momentAt(atNs),
      this.source.surroundings(),
      others,
    ]);
    this.track = track;
    this.surroundings = surroundings;
    this.show(moment, atNs);
  }

  private async momentAt(atNs: number): Promise<Moment> {
    const { source } = this;
    const [mission, targets, plan, troubles, { questions }, report, present] = await Promise.all([
      source.mission(atNs),
      source.targets(atNs),
      source.plan(atNs),
      source.troubles(atNs),
      source.questions(atNs),
      source.report(atNs),
      source.present(atNs),
    ]);
    return {
      mission,
      targets: await targetsWithoutEndedVisits(source, targets, troubles.troubles, mission, atNs),
      plan,
      troubles: troubles.troubles,
      questions,
      report,
      present,
    };
  }

  private show({ mission, targets, plan, troubles, questions, report, present }: Moment, atNs: number): void {
    this.freshness.answer('flight', atNs);
    this.tail = present.tail;
    this.wind = present.wind;
    this.mission = mission;
    this.targets = targets;
    this.plan = plan;
    this.troubles = troubles;
    this.questions = questions;
    this.report = report;
  }

  private showError(subject: string, error: unknown): void {
    this.freshness.fail(subject, failureOf(error));
  }
}

/** The fault of an address with an instant that the record does not have. */
function outside(askedNs: number, fromNs: number, endNs: number): string {
  return `The address has t=${askedNs / 1e9}; the record goes from ${missionTime(fromNs)} to ${missionTime(endNs)}.`;
}
