/** The program and its executed lines at an instant; pure. */

import type { ProgramContents, Task } from '../../record/types';
import { type Names, phrase } from '../../words/phrase';

export interface Place {
  file: string;
  line: number;
}

/** File and line of `file:line:column`; null for other texts. */
export function placeOf(text: string | null): Place | null {
  const [, file, line] = /^(.*):(\d+):\d+$/.exec(text ?? '') ?? [];
  return file && line ? { file, line: Number(line) } : null;
}

export interface LineView {
  number: number;
  text: string;
  /** Tasks whose step is in this line and that have not ended; ongoing tasks come first. */
  tasks: Task[];
  /** True if one of these tasks is ongoing. */
  executing: boolean;
  /** The line that the selection is about. */
  here: boolean;
}

export function linesOf(
  file: string,
  lines: readonly string[],
  tasks: readonly Task[],
  here: Place | null,
): LineView[] {
  const byLine = new Map<number, Task[]>();
  for (const task of tasks) {
    const place = placeOf(task.place);
    if (task.state === 'terminated' || place?.file !== file) continue;
    byLine.set(place.line, [...(byLine.get(place.line) ?? []), task]);
  }
  const isAtWork = (task: Task) => task.state === 'ongoing';
  return lines.map((text, index) => {
    const found = (byLine.get(index + 1) ?? []).sort((a, b) => Number(isAtWork(b)) - Number(isAtWork(a)));
    return {
      number: index + 1,
      text,
      tasks: found,
      executing: found.some(isAtWork),
      here: here?.file === file && here.line === index + 1,
    };
  });
}

export interface ProcedureChoice {
  place: string;
  words: string;
  kind: string;
}

/** Procedures, primitives and solvers with this text in their goal or file, regardless of case. */
export function proceduresWith(
  program: ProgramContents | null,
  find: string,
  names: Names,
): ProcedureChoice[] {
  const wanted = find.trim().toLowerCase();
  return (program?.procedures ?? [])
    .filter(row => wanted === '' || `${row.index} ${row.place}`.toLowerCase().includes(wanted))
    .map(row => ({ place: row.place, words: phrase(row.index, names), kind: row.kind }));
}
