/** The only access to a flight record: requests to the server, and updates while the record grows. */

import { Answers } from './answers';
import { type Carriers, carriersOf, isComplete, type Present, presentOf } from './measured';
import type {
  Events,
  Footprints,
  Growth,
  Holdings,
  Mission,
  MissionFacts,
  Monitors,
  PlanInForce,
  Plans,
  ProgramContents,
  ProgramText,
  Questions,
  RecordedCommands,
  Remedy,
  Report,
  ScoreSoFar,
  Signals,
  SignalWindows,
  Snippet,
  Surroundings,
  Target,
  Targets,
  TaskExplanation,
  Tasks,
  Timeline,
  Track,
  Troubles,
} from './types';

/** A window of the timeline, drawn with this number of pixels, as known at an instant. */
export interface TimelineQuery {
  fromNs: number;
  toNs: number;
  atNs: number;
  pixels: number;
  with: number | null;
}

/** A window of signals, drawn with this number of pixels, as known at an instant. */
export interface SamplesQuery {
  names: string[];
  fromNs: number;
  toNs: number;
  atNs: number;
  pixels: number;
}

/** A window of holdings, as known at an instant. */
export interface HoldingsQuery {
  fromNs: number;
  toNs: number;
  atNs: number;
}

/** Lines of the trace; `fromNs` and `task` null take all. */
export interface EventsQuery {
  fromNs: number | null;
  toNs: number;
  limit: number;
  find: string;
  kinds: string;
  task: number | null;
  /** Only lines with lower numbers: the `next` of an answer whose search has not ended. */
  before?: number | null;
}

/** The requests of panels to a record, the same for finished and growing records. */
export interface RecordSource {
  mission(atNs: number | null): Promise<Mission>;
  track(): Promise<Track>;
  /** The vehicle's measurements shortly before an instant, all of them. */
  present(atNs: number): Promise<Present>;
  tasks(query: { atNs: number; ended: boolean; find: string; with: number | null }): Promise<Tasks>;
  timeline(query: TimelineQuery): Promise<Timeline>;
  targets(atNs: number): Promise<Target[]>;
  surroundings(): Promise<Surroundings>;
  plan(atNs: number): Promise<PlanInForce | null>;
  /** All plans so far; only the last two have routes. */
  plans(atNs: number): Promise<Plans>;
  /** The ground that sensors had seen by then. */
  footprints(atNs: number): Promise<Footprints>;
  /** The holders of each resource. */
  holdings(query: HoldingsQuery): Promise<Holdings>;
  /** Null for missions that are not measured by a score. */
  score(atNs: number): Promise<ScoreSoFar | null>;
  /** Null if the record is not of a mission. */
  facts(): Promise<MissionFacts | null>;
  troubles(atNs: number): Promise<Troubles>;
  /** The questions asked of operators by then. */
  questions(atNs: number): Promise<Questions>;
  events(query: EventsQuery): Promise<Events>;
  /** `explain` also requests the awaited conditions, for which the server restores the instant. */
  why(task: number, atNs: number, explain: boolean): Promise<TaskExplanation>;
  report(atNs: number): Promise<Report>;
  /** The state variables that were measured by then. */
  signals(atNs: number): Promise<Signals>;
  samples(query: SamplesQuery): Promise<SignalWindows>;
  source(place: string): Promise<Snippet>;
  /** The watched conditions of living tasks, or of one task, together with its variables, if one is given. */
  monitors(query: { atNs: number; task: number | null }): Promise<Monitors>;
  /** The files of the program, and their declarations. */
  program(): Promise<ProgramContents>;
  programText(name: string): Promise<ProgramText>;
  /** Commands of operators that were settled by then. */
  commandLog(atNs: number): Promise<RecordedCommands>;
  /** Calls back on every growth until the record is complete; the returned function ends this. */
  watch(onGrowth: (growth: Growth) => void, onConnection: (connected: boolean) => void): () => void;
}

/** The remedies for which readers of the page, who have panels instead of addresses of the server, need other words. */
const REMEDIES: Record<Remedy, string> = {
  session: 'open the page by a link with a token',
  role: 'open the page by the link of an operator or of the pilot in command',
  tasks: 'the agenda lists the tasks',
  records: 'the field “Agent and record” at the top lists the records',
};

/** An error with the server's message, and with its help for readers of the page. */
export class RecordError extends Error {
  readonly help: string;

  constructor(message: string, help: string, remedy: Remedy | null = null) {
    super(message);
    this.help = remedy === null ? help : REMEDIES[remedy];
  }

  /** The error of an answer of the server with an error status. */
  static of(response: Response, body: { error?: string; help?: string; remedy?: Remedy }): RecordError {
    return new RecordError(body.error ?? response.statusText, body.help ?? '', body.remedy ?? null);
  }
}

/** An error with what to do about it. */
export function failureOf(error: unknown): { error: string; help: string } {
  return error instanceof RecordError
    ? { error: error.message, help: error.help }
    : { error: String(error), help: 'reload the page' };
}

/** The parameters of a question that are instants. */
const INSTANTS = 'at from to'.split(' ');
const RETRY_MS = 2000;
/** Duration of the track's tail, and its maximum number of points: as many as 16 samples per second. */
const [TAIL_NS, TAIL_POINTS] = [60e9, 1000];
/** Maximum number of drawn lanes; the others are merged into one. */
const LANES = 60;

/** A record behind `apex serve`. */
export class ServedRecord implements RecordSource {
  /** The address of all questions. */
  private readonly api: string;
  /** The signals that carry the vehicle's state, once they are known. */
  private carriers: Carriers = {};
  /** Requests of the present turn of the event loop by address: an equal one shares the answer. Later ones may have newer answers. */
  private readonly askedAtOnce = new Map<string, Promise<unknown>>();
  private readonly answers = new Answers();

  /** `id` is the record's number in `/api/records`; 0 is the one with which the server was started. */
  constructor(
    readonly base: string,
    readonly id = 0,
  ) {
    this.api = id === 0 ? `${base}/api` : `${base}/api/records/${id}`;
  }

  mission = (atNs: number | null): Promise<Mission> =>
    this.get('mission', { at: atNs === null ? null : whole(atNs) });
  track = (): Promise<Track> => this.get('track', { points: 4000 });
  report = (atNs: number): Promise<Report> => this.get('report', { at: whole(atNs) });
  surroundings = (): Promise<Surroundings> => this.get('surroundings', {});
  signals = async (atNs: number): Promise<Signals> =>
    withoutTruth(await this.get<Signals>('signals', { at: whole(atNs) }));
  samples = (query: SamplesQuery): Promise<SignalWindows> =>
    this.get('samples', {
      names: query.names.join(','),
      from: whole(query.fromNs),
      to: whole(query.toNs),
      at: whole(query.atNs),
      px: Math.round(query.pixels),
    });
  plan = (atNs: number): Promise<PlanInForce | null> => this.get('plan', { at: whole(atNs) });
  plans = (atNs: number): Promise<Plans> => this.get('plans', { at: whole(atNs) });
  footprints = (atNs: number): Promise<Footprints> => this.get('footprints', { at: whole(atNs) });
  holdings = (query: HoldingsQuery): Promise<Holdings> =>
    this.get('holdings', {
      from: whole(query.fromNs),
      to: whole(query.toNs),
      at: whole(query.atNs),
    });
  score = (atNs: number): Promise<ScoreSoFar | null> => this.get('score', { at: whole(atNs) });
  facts = (): Promise<MissionFacts | null> => this.get('facts', {});
  troubles = (atNs: number): Promise<Troubles> => this.get('troubles', { at: whole(atNs) }); // english: allow
  questions = (atNs: number): Promise<Questions> => this.get('questions', { at: whole(atNs) });
  targets = async (atNs: number): Promise<Target[]> =>
    (await this.get<Targets>('targets', { at: whole(atNs) })).targets;
  timeline = (query: TimelineQuery): Promise<Timeline> =>
    this.get('timeline', {
      from: whole(query.fromNs),
      to: whole(query.toNs),
      at: whole(query.atNs),
      px: query.pixels,
      lanes: LANES,
      with: query.with,
    });
  why = (task: number, atNs: number, explain: boolean): Promise<TaskExplanation> =>
    this.get('why', { task, at: whole(atNs), explain });
  source = (place: string): Promise<Snippet> => this.get('source', { place });
  monitors: RecordSource['monitors'] = query =>
    this.get('monitors', { at: whole(query.atNs), task: query.task });
  program = (): Promise<ProgramContents> => this.get('program', {});
  programText = (name: string): Promise<ProgramText> => this.get('program-text', { name });
  commandLog = (atNs: number): Promise<RecordedCommands> => this.get('command-log', { at: whole(atNs) });

  present = async (atNs: number): Promise<Present> => {
    const [fromNs, toNs] = [atNs - TAIL_NS, atNs];
    const [track, carriers] = await Promise.all([
      this.get<Track>('track', { from: whole(fromNs), to: whole(toNs), points: TAIL_POINTS }),
      this.carriersAt(atNs),
    ]);
    const names = Object.values(carriers);
    if (names.length === 0) return presentOf(track, [], carriers);
    const { windows } = await this.samples({ names, fromNs, toNs, atNs, pixels: TAIL_POINTS });
    return presentOf(track, windows, carriers);
  };

  /** The signals that carry the vehicle's state; some may be measured only after `atNs`. */
  private async carriersAt(atNs: number): Promise<Carriers> {
    if (isComplete(this.carriers)) return this.carriers;
    const [{ signals }, { agent }] = await Promise.all([this.signals(atNs), this.mission(atNs)]);
    this.carriers = carriersOf(signals, agent);
    return this.carriers;
  }

  tasks: RecordSource['tasks'] = query =>
    this.get('tasks', { at: whole(query.atNs), ended: query.ended, find: query.find, with: query.with });

  events: RecordSource['events'] = query =>
    this.get('events', {
      from: query.fromNs === null ? null : whole(query.fromNs),
      to: whole(query.toNs),
      limit: query.limit,
      find: query.find,
      kind: query.kinds,
      task: query.task,
      before: query.before ?? null,
    });

  watch: RecordSource['watch'] = (onGrowth, onConnection) => {
    let socket: WebSocket | undefined;
    let timer: ReturnType<typeof setTimeout> | undefined;
    let over = false;
    const open = () => {
      socket = new WebSocket(`${this.api.replace(/^http/, 'ws')}/live`);
      socket.onopen = () => onConnection(true);
      socket.onmessage = message => {
        const growth: Growth = JSON.parse(String(message.data));
        over ||= growth.status === 'complete';
        onGrowth(growth);
      };
      socket.onclose = () => {
        if (over) return;
        onConnection(false);
        timer = setTimeout(open, RETRY_MS);
      };
    };
    open();
    return () => {
      over = true;
      clearTimeout(timer);
      socket?.close();
    };
  };

  private get<T>(what: string, query: Record<string, string | number | boolean | null>): Promise<T> {
    const parameters = new URLSearchParams();
    for (const [name, value] of Object.entries(query)) {
      if (value !== null && value !== '') parameters.set(name, String(value));
    }
    const address = `${this.api}/${what}?${parameters}`;
    const asked = this.askedAtOnce.get(address) as Promise<T> | undefined;
    if (asked) return asked;
    for (const instant of INSTANTS) parameters.delete(instant);
    const answer = this.read<T>(address, `${what}?${parameters}`);
    this.askedAtOnce.set(address, answer);
    queueMicrotask(() => this.askedAtOnce.delete(address));
    return answer;
  }

  /** `question` is the address without instants. */
  private async read<T>(address: string, question: string): Promise<T> {
    let response: Response;
    try {
      response = await fetch(address);
    } catch {
      throw new RecordError('the server does not answer', 'is `apex serve` still running?');
    }
    if (!response.ok) throw RecordError.of(response, await response.json());
    return this.answers.decode(question, await response.text()) as T;
  }
}

/** The signals without the simulator's true values, which are not known in flight. */
export function withoutTruth({ signals }: Signals): Signals {
  return { signals: signals.filter(signal => !signal.attribute.startsWith('truth-')) };
}

/** The server takes whole nanoseconds; a cursor drawn from pixels has fractions. */
function whole(atNs: number): string {
  return Math.round(atNs).toString();
}
