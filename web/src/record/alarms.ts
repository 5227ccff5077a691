/** Alarms: failures, targets left out, watched limits exceeded, requirements at risk, failed navigation, open questions, and whether an operator has acknowledged them; pure. */

import { missionTime, span } from '../time/format';
import { failures } from './failures';
import { stateAlarms } from './states';
import type { AskedQuestion, QuestionEnd, RecordedCommand, SignalWindow, Trouble } from './types';

export interface Alarm {
  /** Identifies the alarm in commands: its words and the time at which it was first raised. */
  id: string;
  words: string;
  cause: string;
  /** Alarms of one cause: the kind of the cause and its place in the program, or the signal. */
  group: string;
  /** First and last time at which the alarm was raised. */
  firstNs: number;
  lastNs: number;
  /** Number of times that the alarm was raised. */
  count: number;
  /** True while it continues. */
  open: boolean;
  /** True for a question, which is answered instead of acknowledged. */
  isQuestion: boolean;
  /** Time at which an operator acknowledged the alarm; null before, and for questions. */
  acknowledgedNs: number | null;
  /** How and when a question ended. Null for other alarms, and while it is open. */
  settled: string | null;
  settledNs: number | null;
  task: number | null;
  target: string | null;
  signal: string | null;
}

/** Entries of the rail that require an operator, with their words; interruptions are normal and require none. */
const CALLS: Record<Trouble['kind'], string | null> = {
  failed: 'failed',
  fault: 'fault',
  'left-out': 'left out',
  ended: 'failed',
  interrupted: null,
};

type Raised = Omit<
  Alarm,
  'id' | 'count' | 'firstNs' | 'lastNs' | 'acknowledgedNs' | 'settled' | 'settledNs'
> & {
  atNs: number;
  settled?: { words: string; atNs: number };
};

/** The alarms at an instant, newest first. Repetitions with the same cause increase the count of one alarm. */
export function alarmsOf(
  troubles: readonly Trouble[],
  questions: readonly AskedQuestion[],
  windows: readonly SignalWindow[],
  commands: readonly RecordedCommand[],
  atNs: number,
  subject: (entry: Trouble) => string,
  signalName: (window: SignalWindow) => string,
): Alarm[] {
  const raised: Raised[] = [
    ...failures(troubles).flatMap(entry => {
      const word = CALLS[entry.kind];
      if (word === null || entry.t_ns > atNs) return [];
      const { task, target, cause, t_ns } = entry;
      const group = [entry.kind, entry.cause_kind, entry.place].join(' ');
      return [
        {
          words: `${word}: ${subject(entry)}`,
          cause,
          group,
          atNs: t_ns,
          open: false,
          isQuestion: false,
          task,
          target,
          signal: null,
        },
      ];
    }),
    ...questions.flatMap(asked => (asked.asked_ns <= atNs ? [waiting(asked, atNs)] : [])),
    ...windows.flatMap(window => exceeded(window, atNs, signalName(window))),
    ...stateAlarms(windows, atNs).map(one => ({
      ...one,
      group: one.signal,
      isQuestion: false,
      task: null,
      target: null,
    })),
  ];
  raised.sort((a, b) => a.atNs - b.atNs);
  const alarms = new Map<string, Alarm>();
  const settled = new Map<string, { words: string; atNs: number } | undefined>();
  for (const { atNs: at, settled: end, ...one } of raised) {
    settled.set(one.words, end);
    const known = alarms.get(one.words);
    if (known) {
      known.lastNs = at;
      known.count += 1;
      known.open = one.open;
      known.cause = one.cause;
      continue;
    }
    const id = `${one.words} (${missionTime(at)})`;
    alarms.set(one.words, {
      ...one,
      id,
      firstNs: at,
      lastNs: at,
      count: 1,
      acknowledgedNs: null,
      settled: null,
      settledNs: null,
    });
  }
  for (const alarm of alarms.values()) {
    const end = settled.get(alarm.words);
    if (end) {
      [alarm.settled, alarm.settledNs] = [end.words, end.atNs];
      continue;
    }
    const said = commands.findLast(
      command => command.end === 'accepted' && command.t_ns <= atNs && command.alarm === alarm.id,
    );
    // An alarm that was raised again needs another acknowledgement.
    alarm.acknowledgedNs = said && said.t_ns >= alarm.lastNs ? said.t_ns : null;
  }
  return [...alarms.values()].sort((a, b) => b.lastNs - a.lastNs);
}

/** A question of the flight to its operators. */
function waiting(asked: AskedQuestion, atNs: number): Raised {
  const { text, options, by_ns, closed_ns, ended } = asked;
  const open = closed_ns === null || closed_ns > atNs;
  const choices = options.length > 0 ? `one of ${options.join(', ')}` : 'the answer is any PDL form';
  const end =
    by_ns === null
      ? ''
      : `; by ${missionTime(by_ns)}${asked.default === null ? '' : `, then ${asked.default}`}`;
  return {
    words: `question: ${text}`,
    cause: `${choices}${end}`,
    group: 'question',
    atNs: asked.asked_ns,
    open,
    isQuestion: true,
    task: asked.task,
    target: null,
    signal: null,
    settled: open ? undefined : { words: endWords(ended), atNs: closed_ns },
  };
}

/** `answered b by ann`, `default b taken`, `withdrawn: its task was interrupted`: how a question ended. */
function endWords(ended: QuestionEnd | null): string {
  switch (ended?.how) {
    case 'answered':
      return `answered ${ended.answer}${ended.author === null ? '' : ` by ${ended.author}`}`;
    case 'default':
      return `default ${ended.answer} taken`;
    case 'withdrawn':
      return `withdrawn: ${ended.reason}`;
    default:
      return 'its task ended';
  }
}

/** The excursions that the executive answered, beyond limits that a step watches all the time. */
function exceeded(window: SignalWindow, atNs: number, name: string): Raised[] {
  return window.excursions.flatMap(one => {
    const limit = window.limits[one.limit];
    if (!limit?.guarded || one.raised_ns === null || one.raised_ns > atNs) return [];
    const ends = one.to_ns >= atNs - 10e9;
    return [
      {
        words: `${name} beyond its limit`,
        cause: `peak ${`${Number(one.peak.toPrecision(4))} ${window.unit}`.trim()}, ${span(one.to_ns - one.from_ns)}, watched by ${limit.step}`,
        group: window.name,
        atNs: one.raised_ns,
        open: ends,
        isQuestion: false,
        task: null,
        target: null,
        signal: window.name,
      },
    ];
  });
}

/** True while an alarm waits for an operator: it is not acknowledged, and is not a question that has ended. */
export function isCalling(alarm: Alarm): boolean {
  return alarm.acknowledgedNs === null && alarm.settledNs === null;
}

/** `4 alarms, 2 not acknowledged, 1 question over`: a question ends by an answer, or when the operator's time is over. */
export function countWords(alarms: readonly Alarm[]): string {
  const open = alarms.filter(isCalling).length;
  const ended = alarms.filter(alarm => alarm.settledNs !== null).length;
  const count = `${alarms.length} ${alarms.length === 1 ? 'alarm' : 'alarms'}, ${open} not acknowledged`;
  if (ended === 0) return count;
  return `${count}, ${ended} ${ended === 1 ? 'question' : 'questions'} over`;
}

/** Alarms within this time, and their number from which on they are a flood (ISA-18.2: ten in ten minutes). */
const [FLOOD_NS, FLOOD_COUNT] = [600e9, 10];

/** Alarms with the same cause, newest first; the group with the newest alarm comes first. */
export interface AlarmGroup {
  cause: string;
  alarms: Alarm[];
}

/** The unacknowledged alarms raised in the ten minutes up to `atNs`, oldest first; null if they are too few for a flood. */
export function floodOf(alarms: readonly Alarm[], atNs: number): Alarm[] | null {
  const late = alarms.filter(
    alarm => isCalling(alarm) && alarm.lastNs <= atNs && alarm.lastNs > atNs - FLOOD_NS,
  );
  return late.length >= FLOOD_COUNT ? late.sort((a, b) => a.firstNs - b.firstNs) : null;
}

/** Alarms grouped by cause, whatever the figures and tasks that the causes name. */
export function groupsOf(alarms: readonly Alarm[]): AlarmGroup[] {
  const groups = new Map<string, AlarmGroup>();
  for (const alarm of alarms) {
    const group = groups.get(alarm.group);
    if (group) group.alarms.push(alarm);
    else groups.set(alarm.group, { cause: alarm.cause, alarms: [alarm] });
  }
  return [...groups.values()];
}

/** `▲` not acknowledged, `△` acknowledged and continuing, `·` over. */
export function alarmGlyph(alarm: Alarm): string {
  if (isCalling(alarm)) return '▲';
  return alarm.open ? '△' : '·';
}
