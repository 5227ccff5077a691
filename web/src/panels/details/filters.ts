/** Filters of the trace: those of `apex trace`, and the names under which this browser saves them; pure except for the storage. */

export interface TraceFilter {
  /** Kinds separated by commas; an empty text admits all kinds. */
  kinds: string;
  find: string;
  /** Number of a task; null for all tasks. */
  task: number | null;
  /** Only lines of the timeline's window. */
  window: boolean;
}

export interface SavedFilter extends TraceFilter {
  name: string;
}

export const NO_FILTER: TraceFilter = { kinds: '', find: '', task: null, window: false };
const KEY = 'sherpa-trace-filters';

/** The number of `T12` or `12`; null for other texts. */
export function taskOf(text: string): number | null {
  const [, number] = /^\s*[tT]?(\d+)\s*$/.exec(text) ?? [];
  return number === undefined ? null : Number(number);
}

/** The filter as an equivalent command, for use in a terminal. */
export function commandOf(record: string, filter: TraceFilter, fromS: number, toS: number): string {
  const words = ['apex trace', /\s/.test(record) ? `'${record}'` : record];
  if (filter.kinds) words.push('--type', filter.kinds);
  if (filter.task !== null) words.push('--object', `T${filter.task}`);
  else if (filter.find.trim()) words.push('--object', `'${filter.find.trim()}'`);
  if (filter.window) words.push(`--from ${fromS}s`);
  words.push('--to', `${toS}s`);
  return words.join(' ');
}

/** The filters in a stored text; entries that are not filters are left out. */
export function parseFilters(text: string | null): SavedFilter[] {
  try {
    const list: unknown = JSON.parse(text ?? '[]');
    if (!Array.isArray(list)) return [];
    return list.flatMap(one => (typeof one?.name === 'string' ? [{ ...NO_FILTER, ...one }] : []));
  } catch {
    return [];
  }
}

export function readFilters(): SavedFilter[] {
  try {
    return parseFilters(window.localStorage.getItem(KEY));
  } catch {
    return [];
  }
}

export function writeFilters(filters: readonly SavedFilter[]): void {
  try {
    window.localStorage.setItem(KEY, JSON.stringify(filters));
  } catch {
    // Without browser storage the filters are kept until the page is left.
  }
}
