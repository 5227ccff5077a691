/** Texts about one task, the log and the report; pure. */

import type { Blocked, EventRow, Moment, Report, Snippet, Task, TaskExplanation } from '../../record/types';
import { civilTime, clock, missionTime, NANOSECONDS_PER_SECOND, span } from '../../time/format';
import { isFailure } from '../../words/state';

export interface CauseView {
  id: number;
  atNs: number;
  time: string;
  heading: string;
  tone: string;
  text: string;
  /** Places in PDL: the clause, then the selected method. */
  places: string[];
}

export interface WhyView {
  sentences: string[];
  /** The newest first, so that the cause of the present state is at the top. */
  causes: CauseView[];
  facts: { name: string; value: string }[];
}

export function whyView(why: TaskExplanation, epochUtc: string | null): WhyView {
  const { task, explanation } = why;
  return {
    sentences: [why.now, ...blockedSentences(explanation.blocked)],
    causes: explanation.history.map(moment => causeView(moment, task.goal)).reverse(),
    facts: facts(task, why.at_ns, epochUtc),
  };
}

function causeView(moment: Moment, goal: string): CauseView {
  const atNs = Math.round(moment.t * NANOSECONDS_PER_SECOND);
  return {
    id: moment.id,
    atNs,
    time: missionTime(atNs),
    heading: headingOf(moment),
    tone: toneOf(moment.kind, moment.to, moment.outcome),
    text: moment.because === '' ? moment.what : joined(subjectOf(moment, goal), moment.because),
    places: [moment.place, moment.method?.place ?? null].filter(place => place !== null),
  };
}

/** A few words: `created`, `started`, `interrupted`, `ended: success`. */
function headingOf({ kind, from, to, outcome }: Moment): string {
  switch (kind) {
    case 'transition':
      if (to === 'terminated') return outcome ? `ended: ${outcome}` : 'ended';
      if (to === 'ongoing') return from === 'interrupted' ? 'resumed' : 'started';
      return to ?? kind;
    case 'satisfied':
      return 'condition satisfied';
    case 'bound':
      return 'variable bound';
    case 'selected':
      return 'method selected';
    case 'refused':
      return 'resource refused';
    default:
      return kind;
  }
}

/** The subject of a moment, unless the panel's title names it. */
function subjectOf(moment: Moment, goal: string): string {
  const { method, subject } = moment;
  if (method) return method.name ? `${method.kind} ${method.name}` : method.kind;
  return subject === goal ? '' : subject;
}

function joined(...parts: (string | null)[]): string {
  return parts.filter(Boolean).join(' — ');
}

function blockedSentences(blocked: Blocked | null): string[] {
  if (!blocked) return [];
  const { resource, by, goal, strengths } = blocked;
  return [`${resource} is held by ${by} ${goal}, priority ${strengths}`];
}

function facts(task: Task, atNs: number, epochUtc: string | null): WhyView['facts'] {
  const civil = civilTime(task.since_ns, epochUtc);
  const since = `${missionTime(task.since_ns)}${civil ? ` · ${civil}` : ''}`;
  const list = [
    { name: task.state === 'terminated' ? 'ended' : 'since', value: since },
    { name: 'for', value: task.state === 'terminated' ? '' : span(atNs - task.since_ns) },
    { name: 'created', value: missionTime(task.created_ns) },
    { name: 'method', value: task.method ?? '' },
    { name: 'step', value: task.tag },
  ];
  return list.filter(fact => fact.value !== '');
}

/** The colour's name for a decision. */
export function toneOf(kind: string, to: string | null, outcome: string | null): string {
  if (kind === 'trouble' || isFailure(outcome)) return 'failed'; // english: allow
  if (kind === 'transition') return to ?? 'pending';
  return kind === 'refused' ? 'interrupted' : 'pending';
}

/** The kinds of events that the log can be narrowed to. */
export const LOG_KINDS: { name: string; kinds: string }[] = [
  { name: 'all', kinds: '' },
  { name: 'states', kinds: 'transition' },
  { name: 'commands', kinds: 'command,withdraw' },
  { name: 'solvers', kinds: 'solve,cancel-solve,procedure-added' },
  { name: 'messages', kinds: 'print,inform,ask,end-application' },
  { name: 'errors', kinds: 'trouble,refused' }, // english: allow
];

export interface LogLine {
  id: number;
  atNs: number;
  time: string;
  task: number | null;
  what: string;
  text: string;
  tone: string;
}

/** The log's lines, newest first. */
export function logLines(events: readonly EventRow[]): LogLine[] {
  return events
    .map(event => ({
      id: event.id,
      atNs: event.t_ns,
      time: missionTime(event.t_ns),
      task: event.task,
      what: event.kind === 'transition' ? (event.outcome ?? event.to_state ?? '') : event.kind,
      text: joined(event.subject, event.text),
      tone: toneOf(event.kind, event.to_state, event.outcome),
    }))
    .reverse();
}

/** Words for a selected event that is not among the lines of the log, and its instant if the cursor is not there. */
export function selectedWords(
  id: number,
  event: EventRow | null,
  atNs: number,
): { words: string; atNs: number | null } {
  if (!event) return { words: `The record has no event ${id}.`, atNs: null };
  if (event.t_ns > atNs) return { words: `Event ${id} comes later than this time.`, atNs: event.t_ns };
  const [line] = logLines([event]);
  const task = line?.task == null ? '' : ` T${line.task}`;
  const words = `Event ${id} is not among the lines below: ${line?.time}${task} ${line?.what} ${line?.text}`;
  return { words, atNs: event.t_ns };
}

/** A section of the report in a form that can be drawn, for any JSON. */
export type SectionView =
  | { title: string; kind: 'text'; text: string }
  | { title: string; kind: 'pairs'; pairs: { name: string; value: string }[] }
  | { title: string; kind: 'table'; columns: string[]; rows: string[][] };

/** A target as flown, and the prediction of its last plan. */
export interface FlownTarget {
  name: string;
  value: string;
  /** The factors and the worth: as flown. */
  flown: string[];
  /** The predicted values; null if no plan predicted them. */
  predicted: string[] | null;
  /** Points lost, by cause. */
  lost: string;
}

/** The columns of factors, in the order in which they are multiplied. */
export const FACTORS = ['coverage', 'resolution', 'clarity', 'timing'] as const;

/** The targets of the report's score, predicted and flown; null if the report has no such score. */
export function flownTargets(report: Report | null): FlownTarget[] {
  const score = report?.sections.find(({ section }) => section === 'score')?.body;
  const targets = isObject(score) && Array.isArray(score.targets) ? score.targets.filter(isObject) : [];
  // Other scores have targets without factors: they are a table of the report.
  return targets.filter(hasFactors).map(target => {
    const losses = Array.isArray(target.losses) ? target.losses.filter(isObject) : [];
    return {
      name: valueText(target.target),
      value: fixed(target.value, 1),
      flown: figures(target),
      predicted: isObject(target.predicted) ? figures(target.predicted) : null,
      lost: losses.map(loss => `${words(valueText(loss.cause))} ${fixed(loss.points, 1)}`).join(', '),
    };
  });
}

function hasFactors(target: Record<string, unknown>): boolean {
  return FACTORS.some(factor => factor in target);
}

function figures(of: Record<string, unknown>): string[] {
  const factor = (name: string) => {
    const member = of[name];
    return fixed(isObject(member) ? member.factor : member, 2);
  };
  return [...FACTORS.map(factor), fixed(of.worth, 1)];
}

function fixed(value: unknown, decimals: number): string {
  return typeof value === 'number' ? value.toFixed(decimals) : '–';
}

export function reportView(report: Report | null): SectionView[] {
  return (report?.sections ?? []).flatMap(({ section, body }): SectionView[] => {
    const title = words(section);
    if (Array.isArray(body) && body.length > 0 && body.every(isObject)) return [tableOf(title, body)];
    if (isObject(body)) {
      // Lists of objects are tables after the totals; targets with factors have a separate one.
      const tables = Object.entries(body).flatMap(([name, value]) =>
        Array.isArray(value) && value.length > 0 && value.every(isObject) && !value.some(hasFactors)
          ? [tableOf(`${title}: ${words(name)}`, value)]
          : [],
      );
      const single = Object.entries(body).filter(
        ([, value]) => !Array.isArray(value) || !value.every(isObject),
      );
      // An empty list of what is not known has nothing to show.
      const pairs = single
        .filter(([, value]) => value !== '')
        .map(([name, value]) => ({ name: labelOf(name), value: pairText(name, value) }));
      return [{ title, kind: 'pairs', pairs }, ...tables];
    }
    const text = Array.isArray(body) ? body.map(valueText).join('\n') : valueText(body);
    return [{ title, kind: 'text', text }];
  });
}

/** Columns that name the subject of a row. */
const SUBJECTS = ['target', 'name', 't', 'time'];

/** A value of a report; times of the mission are times of day. */
function cellText(name: string, value: unknown): string {
  const isTime = typeof value === 'number' && (name === 't' || name === 'begin_s' || name === 'end_s');
  return isTime ? clock(value) : valueText(value);
}

function tableOf(title: string, body: Record<string, unknown>[]): SectionView {
  // The columns that name the subject come first, regardless of the order in the JSON.
  const rank = (column: string) => Number(!SUBJECTS.includes(column));
  const columns = [...new Set(body.flatMap(row => Object.keys(row)))].sort((a, b) => rank(a) - rank(b));
  const rows = body.map(row => columns.map(column => cellText(column, row[column])));
  return { title, kind: 'table', columns: columns.map(labelOf), rows };
}

function isObject(value: unknown): value is Record<string, unknown> {
  return typeof value === 'object' && value !== null && !Array.isArray(value);
}

/** Labels of names in the report whose words say too little; units follow their quantity. */
const LABELS: Record<string, string> = {
  t: 'time',
  begin_s: 'begin',
  end_s: 'end',
  reflies: 'flown again',
  roll_deg_max: 'greatest roll, °',
  altitude_m: 'altitude, m',
};

function labelOf(name: string): string {
  return LABELS[name] ?? words(name);
}

/** A single value; the kind of a score is a word of the report. */
function pairText(name: string, value: unknown): string {
  return name === 'kind' && typeof value === 'string' ? words(value) : cellText(name, value);
}

function words(name: string): string {
  return name.replaceAll('_', ' ').replaceAll('-', ' ');
}

function valueText(value: unknown): string {
  if (value === null || value === undefined) return '–';
  if (typeof value === 'number')
    return Number.isInteger(value) ? String(value) : String(Number(value.toPrecision(5)));
  return typeof value === 'object' ? JSON.stringify(value) : String(value);
}

/** True for a place in a file of the mission; procedures made from plans have names like `<plan 3>` and no file. */
export function hasSource(place: string): boolean {
  return !place.startsWith('<');
}

/** Rank of a task's state as an explanation of the state of its target: the lowest rank is chosen. */
const STATE_RANKS: Record<Task['state'], number> = {
  ongoing: 0,
  interrupted: 1,
  terminated: 2,
  enabled: 3,
  pending: 4,
};

/**
 * The task that observes a target: of the topmost tasks whose goal names it the one at work, or otherwise interrupted, or otherwise the last
 * one that succeeded, or otherwise one that waits. Null if no task has the target.
 */
export function observeTask(tasks: readonly Task[], target: string): Task | null {
  const withTarget = new Map(
    tasks.filter(task => task.targets.includes(target)).map(task => [task.id, task]),
  );
  const isCut = (task: Task) => task.state === 'terminated' && task.outcome !== 'success';
  const rank = (task: Task) => (isCut(task) ? 5 : STATE_RANKS[task.state]);
  const topmost = [...withTarget.values()].filter(
    task => !task.is_message && (task.parent === null || !withTarget.has(task.parent)),
  );
  return topmost.sort((a, b) => rank(a) - rank(b) || b.since_ns - a.since_ns)[0] ?? null;
}

/** Source lines with their numbers; `here` marks the place. */
export function snippetLines(snippet: Snippet): { number: number; text: string; here: boolean }[] {
  return snippet.lines.map((text, index) => {
    const number = snippet.first_line + index;
    return { number, text, here: number === snippet.line };
  });
}
