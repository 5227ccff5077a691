/** What the header says. */

import type { Mission } from '../../record/types';
import { civilTime, missionTime, NANOSECONDS_PER_SECOND } from '../../time/format';

export interface HeaderView {
  title: string;
  /** Who flew what. */
  subtitle: string;
  status: 'complete' | 'live' | 'incomplete';
  statusHelp: string;
  score: string | null;
  time: string;
  civil: string | null;
  end: string;
}

const STATUS_HELP = {
  complete: 'the record was closed properly',
  live: 'the record is being written now',
  incomplete: 'the record was not closed properly: the flight or its program broke off',
};

/** Records shorter than this are watched in tenths of seconds. */
const SHORT_NS = 300 * NANOSECONDS_PER_SECOND;

export function headerView(mission: Mission, atNs: number): HeaderView {
  const decimals = mission.end_ns - mission.from_ns < SHORT_NS ? 1 : 0;
  const ended = mission.end_reason ? ` (${mission.end_reason})` : '';
  return {
    title: mission.mission ?? mission.record,
    subtitle: [mission.agent, mission.vehicle].filter(Boolean).join(' · '),
    status: mission.status,
    statusHelp: STATUS_HELP[mission.status] + ended,
    score: mission.score === null ? null : scoreText(mission.score),
    time: missionTime(atNs, decimals),
    civil: civilTime(atNs, mission.epoch_utc),
    end: missionTime(mission.end_ns, decimals),
  };
}

function scoreText(score: number): string {
  return Math.abs(score) >= 100 ? score.toFixed(0) : score.toFixed(Math.abs(score) >= 10 ? 1 : 2);
}

export function speedText(speed: number): string {
  return `${speed}×`;
}
