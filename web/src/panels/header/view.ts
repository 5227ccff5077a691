/** Contents of the header. */

import type { Mission, ScoreSoFar } from '../../record/types';
import { civilTime, missionTime, NANOSECONDS_PER_SECOND, span } from '../../time/format';

export interface HeaderView {
  title: string;
  /** The agent and its mission. */
  subtitle: string;
  /** One tag: live, recorded, ended, failed or incomplete. */
  status: 'live' | 'recorded' | 'ended' | 'failed' | 'incomplete';
  /** Text of the tag; for a failure it includes the reason. */
  statusText: string;
  statusHelp: string;
  /** The mission score, at the end only. */
  score: string | null;
  /** Name of the score. */
  scoreName: string;
  /** `3 of 22 targets observed`; none without targets. */
  progress: string | null;
  time: string;
  civil: string | null;
  /** `of 24:00:00`, the length of the mission as planned; of a record without a mission its own length. */
  length: string;
}

/** Minimum mission time for which a score stays shown after its instant; at a high speed of the cursor it is one second of watching. */
const SCORE_AGE_NS = 60 * NANOSECONDS_PER_SECOND;

export interface ShownScore {
  text: string;
  help: string;
}

/** The score if the flight ended now; null if the newest known score belongs to another instant. `speed` is that of the cursor. */
export function scoreSoFar(
  known: { atNs: number; score: ScoreSoFar } | null,
  atNs: number,
  speed: number,
): ShownScore | null {
  const ageNs = known ? atNs - known.atNs : 0;
  if (!known || ageNs < 0 || ageNs > Math.max(SCORE_AGE_NS, speed * NANOSECONDS_PER_SECOND)) return null;
  const { counted_ns, benefits, costs, score } = known.score;
  return {
    text: scoreText(score),
    help: `mission score if the flight ended now: ${scoreText(benefits)} points of observations until ${missionTime(counted_ns)}, less costs of ${scoreText(costs)}`,
  };
}

/** Times of records shorter than this are shown in tenths of seconds. */
const SHORT_NS = 300 * NANOSECONDS_PER_SECOND;

/** The header at the cursor's instant; `mission` holds what was known then. */
export function headerView(
  mission: Mission,
  atNs: number,
  following = false,
  durationNs: number | null = null,
  connected = true,
): HeaderView {
  const decimals = mission.end_ns - mission.from_ns < SHORT_NS ? 1 : 0;
  const { targets, observed, score } = mission;
  const length = (ns: number) => missionTime(ns, decimals).slice(2);
  return {
    title: mission.mission ?? mission.record,
    subtitle: [mission.agent, mission.vehicle].filter(Boolean).join(' · '),
    ...statusOf(mission, atNs, following, connected),
    score: score === null ? null : scoreText(score),
    scoreName: mission.score_kind === 'expected-cost-of-ignorance' ? 'expected cost of ignorance' : 'score',
    progress: targets === 0 ? null : `${observed} of ${targets} targets observed`,
    time: missionTime(atNs, decimals),
    civil: civilTime(atNs, mission.epoch_utc),
    length: durationNs === null ? `/ ${length(mission.end_ns)}` : `of ${length(durationNs)}`,
  };
}

/** How many digits the number of observed targets has less than the number of targets. */
export function missingDigits(mission: Mission | null): number {
  return mission ? String(mission.targets).length - String(mission.observed).length : 0;
}

function statusOf(
  mission: Mission,
  atNs: number,
  following: boolean,
  connected: boolean,
): Pick<HeaderView, 'status' | 'statusText' | 'statusHelp'> {
  const { ending, status } = mission;
  if (status === 'live' && !connected)
    return {
      status: 'incomplete',
      statusText: `no connection, known until ${missionTime(mission.end_ns)}`,
      statusHelp: 'the server of the flight does not answer; the flight may continue',
    };
  if (status === 'live') {
    const behind = following ? '' : `, ${span(mission.end_ns - atNs)} behind`;
    return { status, statusText: `live${behind}`, statusHelp: 'the record is being written now' };
  }
  if (status === 'incomplete' && atNs >= mission.end_ns) {
    const statusText = `▲ incomplete: record stops at ${missionTime(mission.end_ns)}`;
    return {
      status,
      statusText,
      statusHelp: 'the record was not closed: the flight or its program was aborted',
    };
  }
  if (ending?.failed) {
    return {
      status: 'failed',
      statusText: `▲ failed: ${ending.reason}`,
      statusHelp: 'the flight ended in failure',
    };
  }
  if (ending) return { status: 'ended', statusText: 'ended', statusHelp: ending.reason };
  return {
    status: 'recorded',
    statusText: 'recorded',
    statusHelp: 'the flight is shown as known at the cursor',
  };
}

function scoreText(score: number): string {
  return Math.abs(score) >= 100 ? score.toFixed(0) : score.toFixed(Math.abs(score) >= 10 ? 1 : 2);
}
