/** Mission time as text. Times are nanoseconds since the mission began; numbers keep them exact for a hundred days. */

export const NANOSECONDS_PER_SECOND = 1e9;

/** `T+1:03:04`; with `decimals` `T+1:03:04.5`. */
export function missionTime(atNs: number, decimals = 0): string {
  return `T${atNs < 0 ? '-' : '+'}${clock(Math.abs(atNs) / NANOSECONDS_PER_SECOND, decimals)}`;
}

/** `1:03:04` for a time of day or a span. */
export function clock(seconds: number, decimals = 0): string {
  const unit = 10 ** decimals;
  // Rounded down: a cursor at the end of a record must not show a second that was never flown.
  const total = Math.floor(seconds * unit + 1e-6) / unit;
  const whole = Math.floor(total);
  const fraction = decimals > 0 ? (total - whole).toFixed(decimals).slice(1) : '';
  return `${Math.floor(whole / 3600)}:${two(Math.floor(whole / 60) % 60)}:${two(whole % 60)}${fraction}`;
}

/** `0:34:40`: a planned time, to the nearest second like those in the planner's reasons. */
export function plannedClock(ns: number): string {
  return clock(Math.round(ns / NANOSECONDS_PER_SECOND));
}

/** `0:34`: a planned time of a row, the minute of the planned second. */
export function plannedMinute(ns: number): string {
  return plannedClock(ns).slice(0, -3);
}

/** `2 h 05 min`, `3 min 20 s`, `4.2 s`, `120 ms`: a span, human-readable. */
export function span(ns: number): string {
  const seconds = ns / NANOSECONDS_PER_SECOND;
  if (seconds >= 3600) return `${Math.floor(seconds / 3600)} h ${two(Math.floor(seconds / 60) % 60)} min`;
  if (seconds >= 60) return `${Math.floor(seconds / 60)} min ${two(Math.floor(seconds) % 60)} s`;
  if (seconds >= 10) return `${Math.floor(seconds)} s`;
  if (seconds >= 1) return `${seconds.toFixed(1)} s`;
  return `${Math.round(seconds * 1000)} ms`;
}

/** `2007-09-08 01:03:04Z`, when the record knows the civil time of mission time 0. */
export function civilTime(atNs: number, epochUtc: string | null): string | null {
  const epoch = epochUtc === null ? Number.NaN : Date.parse(epochUtc);
  if (Number.isNaN(epoch)) return null;
  const at = new Date(epoch + atNs / 1e6);
  return Number.isNaN(at.getTime()) ? null : `${at.toISOString().slice(0, 19).replace('T', ' ')}Z`;
}

/** Distances between time marks that are easy to count, in seconds. */
const STEPS_S = [
  0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800,
  3600, 7200, 10800, 21600, 43200, 86400,
];

/** Marks for a time axis: at most `most`, at round times. */
export function ticks(fromNs: number, toNs: number, most: number): { atNs: number; label: string }[] {
  const spanS = (toNs - fromNs) / NANOSECONDS_PER_SECOND;
  if (!(spanS > 0) || most < 1) return [];
  const step =
    STEPS_S.find(candidate => spanS / candidate <= most) ?? 86400 * Math.ceil(spanS / 86400 / most);
  const decimals = step >= 1 ? 0 : Math.ceil(-Math.log10(step));
  const first = Math.ceil(fromNs / NANOSECONDS_PER_SECOND / step);
  const marks: { atNs: number; label: string }[] = [];
  for (let count = first; count * step <= toNs / NANOSECONDS_PER_SECOND; count += 1) {
    const atNs = count * step * NANOSECONDS_PER_SECOND;
    marks.push({ atNs, label: missionTime(atNs, decimals).slice(atNs < 0 ? 1 : 2) });
  }
  return marks;
}

function two(value: number): string {
  return String(value).padStart(2, '0');
}
