/** The page's state as an address: instant, window of time, selection. Pure. */

import { NANOSECONDS_PER_SECOND } from '../time/format';
import type { Range } from './clock';
import { layoutText, PANELS, type Panel, parseLayout } from './layout';

/** The selection: one thing at a time. */
export type Selection = { task: number } | { target: string } | { event: number } | { plan: number } | null;

/** The contents of an address; null for absent ones. */
export interface Address {
  /** `live` follows the end of a growing record. */
  atNs: number | 'live' | null;
  window: Range | null;
  selection: Selection;
  theme: 'light' | 'dark' | null;
  /** Signals that are plotted, by name without parentheses. */
  strips: string[] | null;
  /** Selected interval of time, for statistics. */
  span: Range | null;
  /** Panel on top of the right slot. */
  tab: Panel | null;
  /** Panel on top of the left slot. */
  left: Panel | null;
  /** The panels of each slot, as text; null is the usual layout. */
  layout: string | null;
  /** Number of the shown record and agent; null is the one with which the server was started. */
  record: number | null;
  /** Number of the record in the comparison. */
  versus: number | null;
  /** Rows of the timeline. */
  rows: Rows | null;
}

/** The kinds of rows of the timeline; all at first. */
export const ROWS = ['all', 'tasks', 'targets', 'resources'] as const;
export type Rows = (typeof ROWS)[number];

/** Reads an address; `faults` has one sentence for each invalid parameter, and the other parameters are used. */
export function readAddress(search: string): { address: Address; faults: string[] } {
  const parameters = new URLSearchParams(search);
  const faults: string[] = [];
  const read = <T>(name: string, parse: (text: string) => T | null, form: string): T | null => {
    const text = parameters.get(name);
    if (text === null) return null;
    const value = parse(text);
    if (value === null) faults.push(`The address has ${name}=${text}; expected ${form}.`);
    return value;
  };
  const address: Address = {
    atNs: read('t', parseInstant, 'seconds of mission time, or live'),
    window: read('w', parseWindow, 'two times in seconds, 3600-7200'),
    selection: read('sel', parseSelection, 'task:NUMBER, target:NAME, event:NUMBER or plan:NUMBER'),
    strips: read('strips', text => text.split(',').filter(Boolean), 'names of signals'),
    span: read('range', parseWindow, 'two times in seconds, 3600-7200'),
    tab: read('tab', text => PANELS.find(panel => panel === text) ?? null, PANELS.join(', ')),
    left: read('left', text => PANELS.find(panel => panel === text) ?? null, PANELS.join(', ')),
    layout: read(
      'layout',
      text => {
        const layout = parseLayout(text);
        return layout && layoutText(layout);
      },
      'panels of both slots, agenda.objects_why.signals',
    ),
    record: read('rec', parseNumber, 'the number of a record'),
    versus: read('vs', parseNumber, 'the number of a record'),
    rows: read('rows', text => ROWS.find(rows => rows === text) ?? null, ROWS.join(', ')),
    theme: read('theme', text => (text === 'light' || text === 'dark' ? text : null), 'light or dark'),
  };
  return { address, faults };
}

/** The address for a state. `before` is the present address, whose unknown parameters are kept. */
export function writeAddress(before: string, address: Address): string {
  const parameters = new URLSearchParams(before);
  const set = (name: string, value: string | null) =>
    value === null ? parameters.delete(name) : parameters.set(name, value);
  const { atNs, window, selection } = address;
  set('t', atNs === null ? null : atNs === 'live' ? 'live' : seconds(atNs));
  set('w', window && `${seconds(window.fromNs)}-${seconds(window.toNs)}`);
  set('sel', selectionText(selection));
  set('tab', address.tab);
  set('left', address.left);
  set('layout', address.layout || null);
  set('rec', address.record === null ? null : String(address.record));
  set('vs', address.versus === null ? null : String(address.versus));
  set('rows', address.rows === 'all' ? null : address.rows);
  set('strips', address.strips?.join(',') ?? null);
  set('range', address.span && `${seconds(address.span.fromNs)}-${seconds(address.span.toNs)}`);
  set('theme', address.theme);
  // Colons are legal in a query and stay readable.
  const text = parameters.toString().replaceAll('%3A', ':').replaceAll('%2C', ',');
  return text === '' ? '' : `?${text}`;
}

/** `task:12`; null without a selection. */
export function selectionText(selection: Selection): string | null {
  const [kind, name] = Object.entries(selection ?? {})[0] ?? [];
  return kind === undefined ? null : `${kind}:${name}`;
}

export function sameSelection(a: Selection, b: Selection): boolean {
  return JSON.stringify(a) === JSON.stringify(b);
}

function seconds(ns: number): string {
  return String(Math.round(ns / (NANOSECONDS_PER_SECOND / 1000)) / 1000);
}

function parseInstant(text: string): number | 'live' | null {
  return text === 'live' ? text : parseSeconds(text);
}

function parseNumber(text: string): number | null {
  return /^\d+$/.test(text) ? Number(text) : null;
}

function parseSeconds(text: string): number | null {
  return /^-?\d+(\.\d+)?$/.test(text) ? Math.round(Number(text) * NANOSECONDS_PER_SECOND) : null;
}

function parseWindow(text: string): Range | null {
  const [, from, to] = /^(-?[\d.]+)-(-?[\d.]+)$/.exec(text) ?? [];
  const [fromNs, toNs] = [parseSeconds(from ?? ''), parseSeconds(to ?? '')];
  return fromNs !== null && toNs !== null && fromNs < toNs ? { fromNs, toNs } : null;
}

function parseSelection(text: string): Selection {
  const [, kind, name = ''] = /^(task|target|event|plan):(.+)$/.exec(text) ?? [];
  if (kind === 'target') return { target: name };
  const number = parseNumber(name);
  if (number === null || !Number.isSafeInteger(number)) return null;
  if (kind === 'task') return { task: number };
  if (kind === 'event') return { event: number };
  return kind === 'plan' ? { plan: number } : null;
}
