/** The explanation as a tree: the server's typed answer as rows of conditions, values and causes; pure. */

import type { Link, Observation, Unmet, Why } from '../../record/types';
import { missionTime, NANOSECONDS_PER_SECOND, span } from '../../time/format';
import { brief, type Names, phrase } from '../../words/phrase';

/** Samples behind a leaf, which the signals panel can show. */
export interface Behind {
  variable: string;
  fromNs: number;
  toNs: number;
}

export interface Node {
  id: string;
  /** ● holds, ○ does not hold, ◌ unknown, ▸ a cause. */
  glyph: '●' | '○' | '◌' | '▸';
  text: string;
  /** The part that the text leaves out; empty if there is none. */
  full: string;
  atNs: number | null;
  task: number | null;
  place: string | null;
  source: string | null;
  behind: Behind | null;
  children: Node[];
}

const ns = (seconds: number) => Math.round(seconds * NANOSECONDS_PER_SECOND);

function node(id: string, glyph: Node['glyph'], text: string, rest: Partial<Node> = {}): Node {
  return {
    id,
    glyph,
    text,
    full: '',
    atNs: null,
    task: null,
    place: null,
    source: null,
    behind: null,
    children: [],
    ...rest,
  };
}

/** The branches of the tree: the cause of the task's state, the conditions that it waits for, and the methods for its goal. */
export function whyTree(why: Why, names: Names): Node[] {
  const branches: Node[] = [];
  if (why.because) branches.push(linkNode(why.because, 'because', names));
  if (why.waiting.length > 0) {
    const children = why.waiting.map((part, index) => unmetNode(part, `waits.${index}`, names));
    branches.push(node('waits', '○', `it waits for ${waitsWords(children.length)}`, { children }));
  }
  const others = why.choices.filter(choice => !(choice.matches && why.choices.length === 1));
  if (others.length > 0) {
    const children = others.map((choice, index) =>
      node(
        `choices.${index}`,
        choice.matches ? '●' : '○',
        `${phrase(choice.index, names)}: ${choice.because}`,
        {
          full: choice.index,
          place: choice.place,
        },
      ),
    );
    branches.push(node('choices', '▸', 'methods for its goal', { children }));
  }
  return branches;
}

function waitsWords(count: number): string {
  return count === 1 ? 'one condition' : `${count} conditions`;
}

function linkNode(link: Link, id: string, names: Names): Node {
  const evidence = link.cause?.evidence ?? [];
  const told = [link.what, link.because].filter(Boolean).join(': ');
  const children = [
    ...evidence.map((one, index) => evidenceNode(one, `${id}.e${index}`, names)),
    ...link.causes.map((cause, index) => linkNode(cause, `${id}.${index}`, names)),
  ];
  if (link.more) children.push(node(`${id}.more`, '◌', 'there is more below: select the task to continue'));
  return node(id, link.kind === null ? '●' : '▸', brief(told, names), {
    full: told,
    atNs: ns(link.t),
    task: link.task_number,
    place: link.place,
    source: link.source?.trim() ?? null,
    children,
  });
}

/** A condition that does not hold yet: the known value and its distance from the limit, and the time since the last change. */
function unmetNode(part: Unmet, id: string, names: Names): Node {
  const words = [brief(part.what, names), brief(part.now, names)].filter(Boolean).join(': ');
  const full = [part.what, part.now].filter(Boolean).join(': ');
  const until = part.until === null ? '' : `, by ${missionTime(ns(part.until))} at the latest`;
  return node(id, part.unobserved ? '◌' : '○', `${words}${until}`, {
    full,
    atNs: part.since === null ? null : ns(part.since),
    task: part.task_number,
    place: part.place,
  });
}

/** An observation with its value: the leaf that is the evidence for a cause. */
function evidenceNode(one: Observation, id: string, names: Names): Node {
  const variable = (name: string) => phrase(name, names);
  switch (one.type) {
    case 'sample':
      return leaf(id, `${variable(one.variable)} ${one.value}`, one.at, one.variable, one.at, one.at);
    case 'estimate':
      return leaf(id, `${variable(one.variable)} about ${one.value}`, one.at, one.variable, one.at, one.at);
    case 'run':
      return leaf(
        id,
        `${variable(one.variable)} for ${span(ns(one.to - one.from))}, ${one.samples} samples`,
        one.from,
        one.variable,
        one.from,
        one.to,
      );
    case 'aggregate':
      return leaf(
        id,
        `${one.name} of ${variable(one.variable)} ${one.value}, ${one.samples} samples`,
        one.to,
        one.variable,
        one.from,
        one.to,
      );
    case 'event':
      return leaf(id, brief(one.form, names), one.at, null, 0, 0, one.form);
    case 'task-state':
      return leaf(id, `${one.task} ${one.word}`, one.at);
    case 'task-end':
      return leaf(id, `${one.task} ended`, one.at);
    case 'instant':
      return leaf(id, 'an instant was reached', one.at);
    case 'function':
      return leaf(id, `${brief(one.expression, names)} = ${one.value}`, one.at, null, 0, 0, one.expression);
    case 'absence':
      return leaf(id, `not: ${brief(one.condition, names)}`, one.at, null, 0, 0, one.condition);
  }
}

function leaf(
  id: string,
  text: string,
  at: number,
  variable: string | null = null,
  from = 0,
  to = 0,
  full = '',
): Node {
  const behind = variable === null ? null : { variable, fromNs: ns(from), toNs: ns(to) };
  return node(id, '●', text, { atNs: ns(at), behind, full: full === text ? '' : full });
}

export interface TreeRow {
  node: Node;
  depth: number;
  open: boolean;
}

/** The rows in reading order; nodes are open unless they are closed by hand. */
export function treeRows(nodes: readonly Node[], closed: ReadonlySet<string>, depth = 0): TreeRow[] {
  return nodes.flatMap(one => {
    const open = one.children.length > 0 && !closed.has(one.id);
    return [{ node: one, depth, open }, ...(open ? treeRows(one.children, closed, depth + 1) : [])];
  });
}

/** All leaves with samples behind them. */
export function behindOf(nodes: readonly Node[]): Behind[] {
  return nodes.flatMap(one => [...(one.behind ? [one.behind] : []), ...behindOf(one.children)]);
}

/** The whole tree as text: two blanks for each level, the instant after the words. */
export function treeText(nodes: readonly Node[], depth = 0): string {
  return nodes
    .map(node => {
      const at = node.atNs === null ? '' : `  ${missionTime(node.atNs)}`;
      const line = `${'  '.repeat(depth)}${node.glyph} ${node.full || node.text}${at}\n`;
      return line + treeText(node.children, depth + 1);
    })
    .join('');
}
