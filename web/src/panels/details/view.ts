/** What is told about one task, the log and the report; pure. */

import type { EventRow, Report, Snippet, Task, Why } from '../../record/types';
import { civilTime, missionTime, span } from '../../time/format';

export interface CauseView {
  id: number;
  atNs: number;
  time: string;
  heading: string;
  tone: string;
  text: string;
  place: string | null;
}

export interface WhyView {
  sentences: string[];
  waiting: { what: string; now: string; place: string | null }[];
  /** The newest first: why it is as it is now stands at the top. */
  causes: CauseView[];
  facts: { name: string; value: string }[];
}

export function whyView(why: Why, epochUtc: string | null): WhyView {
  const { task } = why;
  return {
    sentences: [why.now, ...blockedOf(why.explainer?.blocked)],
    waiting: waitingOf(why.explainer?.waiting),
    causes: why.because
      .map(cause => ({
        id: cause.id,
        atNs: cause.t_ns,
        time: missionTime(cause.t_ns),
        heading: cause.heading,
        tone: toneOf(cause),
        text: [subjectOf(cause, task.goal), withoutPlace(cause.text, cause.place)]
          .filter(Boolean)
          .join(' — '),
        place: cause.place,
      }))
      .reverse(),
    facts: facts(task, why.at_ns, epochUtc),
  };
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

/** The causes' own texts end with their place; the page shows places as links. */
export function withoutPlace(text: string | null, place: string | null): string {
  if (!text) return '';
  return place && text.endsWith(`; from ${place}`) ? text.slice(0, -`; from ${place}`.length) : text;
}

/** What an event is about, unless that is said already. */
function subjectOf(event: EventRow, said: string): string {
  return event.subject === null || event.subject === said ? '' : event.subject;
}

/** The colour's name for an event. */
export function toneOf(event: EventRow): string {
  if (event.kind === 'trouble' || event.outcome?.startsWith('fail')) return 'skipped';
  if (event.outcome?.startsWith('success')) return 'observed';
  if (event.kind === 'transition') return event.to_state ?? 'pending';
  return event.kind === 'refused' ? 'interrupted' : 'planned';
}

/** The parts of conditions that do not hold yet, as the explainer names them; members of another shape are passed over. */
function waitingOf(value: unknown): WhyView['waiting'] {
  if (!Array.isArray(value)) return [];
  return value.filter(isObject).flatMap(({ what, now, place }) => {
    if (typeof what !== 'string') return [];
    return { what, now: textOr(now, ''), place: typeof place === 'string' ? place : null };
  });
}

function blockedOf(value: unknown): string[] {
  if (!isObject(value) || typeof value.by !== 'string') return [];
  const { by, strengths } = value;
  const priorities = typeof strengths === 'string' ? `, priority ${strengths}` : '';
  return [
    `${textOr(value.resource, 'Its resource')} is with ${by} ${textOr(value.goal, '')}${priorities}`.trim(),
  ];
}

function textOr(value: unknown, otherwise: string): string {
  return typeof value === 'string' ? value : otherwise;
}

/** The kinds of events that the log can be narrowed to. */
export const LOG_KINDS: { name: string; kinds: string }[] = [
  { name: 'all', kinds: '' },
  { name: 'states', kinds: 'transition' },
  { name: 'commands', kinds: 'command,withdraw' },
  { name: 'solvers', kinds: 'solve,cancel-solve,procedure-added' },
  { name: 'messages', kinds: 'print,inform,ask,end-application' },
  { name: 'trouble', kinds: 'trouble,refused' },
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
      text: [subjectOf(event, ''), withoutPlace(event.text, event.place)].filter(Boolean).join(' — '),
      tone: toneOf(event),
    }))
    .reverse();
}

/** A section of the report as something to draw, whatever its JSON is. */
export type SectionView =
  | { title: string; kind: 'text'; text: string }
  | { title: string; kind: 'pairs'; pairs: { name: string; value: string }[] }
  | { title: string; kind: 'table'; columns: string[]; rows: string[][] };

export function reportView(report: Report | null): SectionView[] {
  return (report?.sections ?? []).map(({ section, body }) => {
    const title = words(section);
    if (Array.isArray(body) && body.length > 0 && body.every(isObject)) {
      const columns = [...new Set(body.flatMap(row => Object.keys(row)))];
      const rows = body.map(row => columns.map(column => valueText(row[column])));
      return { title, kind: 'table', columns: columns.map(words), rows };
    }
    if (isObject(body)) {
      const pairs = Object.entries(body).map(([name, value]) => ({
        name: words(name),
        value: valueText(value),
      }));
      return { title, kind: 'pairs', pairs };
    }
    return {
      title,
      kind: 'text',
      text: Array.isArray(body) ? body.map(valueText).join('\n') : valueText(body),
    };
  });
}

function isObject(value: unknown): value is Record<string, unknown> {
  return typeof value === 'object' && value !== null && !Array.isArray(value);
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

/** Source lines with their numbers; `here` marks the place. */
export function snippetLines(snippet: Snippet): { number: number; text: string; here: boolean }[] {
  return snippet.lines.map((text, index) => {
    const number = snippet.first_line + index;
    return { number, text, here: number === snippet.line };
  });
}
