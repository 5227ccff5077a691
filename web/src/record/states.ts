/** Alarms of state variables whose values are words: requirements at risk, and navigation that is not good. Pure. */

import { missionTime, span } from '../time/format';
import type { Signal, SignalWindow } from './types';

/** The attributes that are watched, with the word of their normal state. */
const NORMAL: Readonly<Record<string, string>> = { 'requirement-state': 'kept', 'navigation-state': 'good' };

/** The word of a requirement that cannot be judged. */
const UNKNOWN = 'unknown';

/** True for a state variable whose words other than the normal one are alarms. */
export function isWatchedState(signal: Pick<Signal, 'kind' | 'attribute'>): boolean {
  return signal.kind === 'words' && signal.attribute in NORMAL;
}

/** A stretch of time in which a watched state variable was not normal. */
export interface Abnormal {
  window: SignalWindow;
  word: string;
  fromNs: number;
  /** The instant at which it changed; null while it lasts. */
  toNs: number | null;
}

/** The stretches of a window up to an instant, oldest first. */
export function abnormalOf(window: SignalWindow, atNs: number): Abnormal[] {
  const stretches: Abnormal[] = [];
  if (!isWatchedState(window)) return stretches;
  window.t_ns.forEach((fromNs, index) => {
    if (fromNs > atNs) return;
    const last = stretches.at(-1);
    const word = window.words[window.mean[index] ?? -1] ?? '';
    if (last && last.toNs === null) {
      if (last.word === word) return;
      last.toNs = fromNs;
    }
    if (word !== NORMAL[window.attribute]) stretches.push({ window, word, fromNs, toNs: null });
  });
  return stretches;
}

/** The names of the margins of requirements that were at risk at some time. */
export function marginsOf(windows: readonly SignalWindow[]): string[] {
  return windows
    .filter(window => window.attribute === 'requirement-state' && abnormalOf(window, Infinity).length > 0)
    .map(window => `(margin ${window.object})`);
}

/** An alarm of a watched state variable. */
export interface StateAlarm {
  words: string;
  cause: string;
  atNs: number;
  open: boolean;
  signal: string;
}

/** The alarms of watched state variables up to an instant; `windows` also has the margins of requirements at risk. */
export function stateAlarms(windows: readonly SignalWindow[], atNs: number): StateAlarm[] {
  return windows.flatMap(window => abnormalOf(window, atNs).map(one => stateAlarm(one, windows, atNs)));
}

function stateAlarm(one: Abnormal, windows: readonly SignalWindow[], atNs: number): StateAlarm {
  const { window, word, fromNs, toNs } = one;
  const common = { atNs: fromNs, open: toNs === null };
  const object = window.object.replaceAll('-', ' ');
  const state = word.replaceAll('-', ' ');
  const lasted = toNs === null ? '' : `; until ${missionTime(toNs)}`;
  if (window.attribute === 'navigation-state')
    return {
      ...common,
      words: `navigation of ${object} ${state}`,
      cause: `the positions shown are those that the autopilot assumes; the true ones are not known${lasted}`,
      signal: window.name,
    };
  if (word === UNKNOWN)
    return {
      ...common,
      words: `requirement ${object} not judged`,
      cause: `the vehicle does not report what its margin is computed from; ${span((toNs ?? atNs) - fromNs)}${lasted}`,
      signal: window.name,
    };
  const margin = windows.find(other => other.attribute === 'margin' && other.object === window.object);
  const least = margin && leastOf(margin, fromNs, Math.min(toNs ?? atNs, atNs));
  return {
    ...common,
    words: `requirement ${object} ${state}`,
    cause: `${least ?? 'its margin is not recorded'}; ${span((toNs ?? atNs) - fromNs)}${lasted}`,
    signal: least && margin ? margin.name : window.name,
  };
}

/** `margin -3.82 m at T+0:00:09, below its limit`: the least value in a stretch of time; null without values. */
function leastOf(margin: SignalWindow, fromNs: number, toNs: number): string | null {
  let best = -1;
  margin.t_ns.forEach((time, index) => {
    if (time < fromNs || time > toNs) return;
    if (best < 0 || (margin.low[index] ?? Infinity) < (margin.low[best] ?? Infinity)) best = index;
  });
  const value = margin.low[best];
  if (value === undefined) return null;
  const at = missionTime(margin.t_ns[best] ?? fromNs);
  const figure = `${Number(value.toPrecision(4))} ${margin.unit}`.trim();
  return `margin ${figure} at ${at}${value < 0 ? ', below its limit' : ''}`;
}

/** `position uncertain: navigation degraded since T+0:16:45`; null while the navigation is good, or if it is not reported. */
export function navigationNote(windows: readonly SignalWindow[], atNs: number): string | null {
  for (const window of windows) {
    if (window.attribute !== 'navigation-state') continue;
    const last = abnormalOf(window, atNs).at(-1);
    if (last && last.toNs === null)
      return `position uncertain: navigation ${last.word} since ${missionTime(last.fromNs)}`;
  }
  return null;
}
