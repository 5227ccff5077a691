import { describe, expect, it } from 'vitest';
import type { EventRow, Moment, Task, TaskExplanation, Why } from '../../record/types';
import { treeText, whyTree } from './tree';
import {
  flownTargets,
  hasSource,
  logLines,
  observeTask,
  reportView,
  selectedWords,
  snippetLines,
  toneOf,
  whyView,
} from './view';

function moment(id: number, more: Partial<Moment> = {}): Moment {
  return {
    id,
    t: id,
    kind: 'transition',
    what: 'enabled -> ongoing',
    because: 'it needs no resources',
    place: 'a.pdl:3:1',
    from: 'enabled',
    to: 'ongoing',
    outcome: null,
    subject: '(take-off)',
    method: null,
    cause: { kind: 'resources-granted', parts: [], evidence: [], observed: '' },
    ...more,
  };
}

const explanation: Why = {
  version: 1,
  question: 'why',
  kind: 'task',
  asked: 'T4',
  agent: 'pilot',
  t: 65,
  task: 'T4',
  tag: 's1',
  goal: '(take-off)',
  state: 'ongoing',
  since: 5,
  outcome: null,
  priority: 3,
  holds: [],
  method: 'primitive a.pdl:9:1',
  place: 'a.pdl:3:1',
  because: null,
  choices: [],
  history: [moment(1), moment(2)],
  waiting: [],
  blocked: null,
  subtasks: [],
};

const why: TaskExplanation = {
  at_ns: 65e9,
  task: {
    id: 4,
    parent: 1,
    tag: 's1',
    goal: '(take-off)',
    state: 'ongoing',
    outcome: null,
    since_ns: 5e9,
    created_ns: 0,
    method: 'primitive a.pdl:9:1',
    targets: [],
    is_message: false,
    method_place: 'a.pdl:9:1',
    place: 'a.pdl:3:1',
  },
  now: 'T4 is ongoing because it needs no resources',
  cause: 'it needs no resources',
  explanation,
  left_out: false,
  children: [],
  explanation_error: null,
};

function withHistory(...history: Moment[]): TaskExplanation {
  return { ...why, explanation: { ...explanation, history } };
}

describe('why', () => {
  it('has the newest moment first, with its place as a link next to the text', () => {
    const view = whyView(why, null);
    expect(view.causes.map(entry => entry.id)).toEqual([2, 1]);
    expect(view.causes[0]).toMatchObject({ atNs: 2e9, text: 'it needs no resources', places: ['a.pdl:3:1'] });
    expect(view.facts.find(fact => fact.name === 'for')?.value).toBe('1 min 00 s');
  });

  it('names what happened from the fields of a moment', () => {
    const selected = moment(3, {
      kind: 'selected',
      from: null,
      to: null,
      because: 'it is the most specific of 2 matches',
      method: { kind: 'procedure', place: 'a.pdl:9:1', name: null },
    });
    const print = moment(4, { kind: 'print', what: 'prints hello', because: '', subject: '', place: null });
    const refused = moment(5, { kind: 'refused', subject: 'camera-1', because: 'T9 outranks it' });
    const view = whyView(
      withHistory(
        moment(1, { kind: 'created', from: null, to: null }),
        moment(2, { from: 'interrupted' }),
        selected,
        print,
        refused,
        moment(6, { to: 'terminated', outcome: 'success' }),
      ),
      null,
    );
    expect(view.causes.reverse().map(({ heading, text }) => [heading, text])).toEqual([
      ['created', 'it needs no resources'],
      ['resumed', 'it needs no resources'],
      ['method selected', 'procedure — it is the most specific of 2 matches'],
      ['print', 'prints hello'],
      ['resource refused', 'camera-1 — T9 outranks it'],
      ['ended: success', 'it needs no resources'],
    ]);
    expect(view.causes[2]?.places).toEqual(['a.pdl:3:1', 'a.pdl:9:1']);
  });

  it('says what is waited for and who has the resource', () => {
    const waiting = {
      kind: 'condition',
      what: '(on camera-1)',
      now: 'off',
      unobserved: false,
      since: null,
      until: null,
      distance: null,
      task: null,
      task_number: null,
      place: 'a.pdl:4:2',
    };
    const blocked = {
      by: 'T9',
      goal: '(pan)',
      resource: 'camera',
      since: 4,
      winner_priority: 7.1,
      loser_priority: 3,
      winner_cost: 0.1,
      loser_cost: 0,
      strengths: '7 + interrupt cost 0.1 against 3',
    };
    const full = { ...why, explanation: { ...explanation, waiting: [waiting], blocked } };
    const view = whyView(full, '2007-09-08T01:00:00Z');
    expect(view.sentences).toEqual([
      why.now,
      'camera is held by T9 (pan), priority 7 + interrupt cost 0.1 against 3',
    ]);
    const text = treeText(whyTree(full.explanation, new Map()));
    expect(text.split('\n').filter(line => line.startsWith('○ it waits for')).length).toBe(1);
    expect(text).toMatch(/^ {2}\S/m);
    const waits = whyTree(full.explanation, new Map()).find(node => node.id === 'waits');
    expect(waits?.children.map(leaf => [leaf.glyph, leaf.text, leaf.place])).toEqual([
      ['○', 'on camera 1: off', 'a.pdl:4:2'],
    ]);
    expect(view.facts[0]?.value).toBe('T+0:00:05 · 2007-09-08 01:00:05Z');
  });
});

it('the log names ends by their outcome, and errors by their colour', () => {
  const event = (id: number, more: Partial<EventRow>): EventRow => ({
    id,
    t_ns: id * 1e9,
    kind: 'transition',
    task: 4,
    from_state: 'enabled',
    to_state: 'ongoing',
    outcome: null,
    subject: '(take-off)',
    text: 'it needs no resources',
    place: 'a.pdl:3:1',
    ...more,
  });
  const lines = logLines([event(1, {}), event(2, { outcome: 'failure', to_state: 'terminated' })]);
  expect(lines.map(line => line.what)).toEqual(['failure', 'ongoing']);
  expect(lines[1]?.text).toBe('(take-off) — it needs no resources');
  expect(lines[0]?.tone).toBe('failed');
  expect(toneOf('refused', null, null)).toBe('interrupted');
  expect(toneOf('transition', 'terminated', 'invariant violated')).toBe('failed');
  // A selected event that the filter leaves out is described; one that comes later is not.
  expect(selectedWords(2, event(2, {}), 9e9)).toEqual({
    words: 'Event 2 is not among the lines below: T+0:00:02 T4 ongoing (take-off) — it needs no resources',
    atNs: 2e9,
  });
  expect(selectedWords(2, event(2, {}), 1e9)).toEqual({
    words: 'Event 2 comes later than this time.',
    atNs: 2e9,
  });
  expect(selectedWords(3, null, 1e9)).toEqual({ words: 'The record has no event 3.', atNs: null });
});

it('a report of any JSON can be drawn', () => {
  const sections = [
    { section: 'score', body: { score: 0.123456, of: null } },
    { section: 'per-target', body: [{ name: 'Zaca', value: 1 }, { name: 'Lick' }] },
    { section: 'notes', body: 'calm' },
  ];
  const [score, targets, notes] = reportView({ sections });
  expect(score).toEqual({
    title: 'score',
    kind: 'pairs',
    pairs: [
      { name: 'score', value: '0.12346' },
      { name: 'of', value: '–' },
    ],
  });
  expect(targets).toMatchObject({
    title: 'per target',
    columns: ['name', 'value'],
    rows: [
      ['Zaca', '1'],
      ['Lick', '–'],
    ],
  });
  expect(notes).toMatchObject({ kind: 'text', text: 'calm' });
  expect(reportView(null)).toEqual([]);
  // A cost of ignorance has a table of its targets, and no factors.
  const cost = {
    kind: 'expected-cost-of-ignorance',
    total: 293,
    targets: [{ target: 'barn', observations: 1 }],
  };
  const watched = { sections: [{ section: 'score', body: cost }] };
  expect(flownTargets(watched)).toEqual([]);
  expect(reportView(watched)).toMatchObject([
    { title: 'score', kind: 'pairs' },
    { title: 'score: targets', kind: 'table', columns: ['target', 'observations'], rows: [['barn', '1']] },
  ]);
});

it('a snippet marks its place', () => {
  const lines = snippetLines({ name: 'a', line: 3, first_line: 2, lines: ['x', 'y'] });
  expect(lines[1]).toEqual({ number: 3, text: 'y', here: true });
  expect([hasSource('a.pdl:3:1'), hasSource('<plan 3>:1:1')]).toEqual([true, false]);
});

it('the report has predicted next to flown for every target', () => {
  const factors = (factor: number) =>
    Object.fromEntries(['coverage', 'resolution', 'clarity', 'timing'].map(name => [name, { factor }]));
  const predicted = { ...factors(0.5), worth: 45 };
  const zaca = { target: 'Zaca', value: 90, worth: 70.63, ...factors(0.9), predicted };
  const losses = [{ cause: 'too-coarse', points: 19.32 }];
  const body = {
    score: 992.75,
    targets: [
      { ...zaca, losses },
      { ...zaca, predicted: null },
    ],
  };
  const report = { sections: [{ section: 'score', body }] };
  expect(flownTargets(report)).toEqual([
    {
      name: 'Zaca',
      value: '90.0',
      flown: ['0.90', '0.90', '0.90', '0.90', '70.6'],
      predicted: ['0.50', '0.50', '0.50', '0.50', '45.0'],
      lost: 'too coarse 19.3',
    },
    {
      name: 'Zaca',
      value: '90.0',
      flown: ['0.90', '0.90', '0.90', '0.90', '70.6'],
      predicted: null,
      lost: '',
    },
  ]);
  expect(flownTargets(null)).toEqual([]);
  expect(reportView(report)).toEqual([
    { title: 'score', kind: 'pairs', pairs: [{ name: 'score', value: '992.75' }] },
  ]);
});

it('names of the report are labels, and empty values are left out', () => {
  const visit = { begin_s: 1238.7, reflies: 0, roll_deg_max: 1.9, target: 'across' };
  const sections = [
    { section: 'score', body: { kind: 'mission-score', not_known: '', score: 1 } },
    { section: 'visits', body: [visit] },
  ];
  expect(reportView({ sections })).toMatchObject([
    {
      pairs: [
        { name: 'kind', value: 'mission score' },
        { name: 'score', value: '1' },
      ],
    },
    {
      columns: ['target', 'begin', 'flown again', 'greatest roll, °'],
      rows: [['across', '0:20:38', '0', '1.9']],
    },
  ]);
});

it('a target leads to the task that observes it', () => {
  const task = (
    id: number,
    parent: number | null,
    targets: string[],
    state: string,
    outcome: string | null = null,
  ) => ({ id, parent, targets, is_message: id === 3, state, outcome, since_ns: id }) as Task;
  const tasks = [
    task(0, null, [], 'ongoing'),
    task(1, 0, ['barn'], 'terminated', 'success'),
    task(2, 0, ['barn'], 'terminated', 'cut'),
    task(3, 0, ['barn'], 'ongoing'),
    task(4, 0, ['barn'], 'pending'),
    task(5, 0, ['mill'], 'ongoing'),
    task(6, 5, ['mill'], 'ongoing'),
  ];
  expect(observeTask(tasks, 'barn')?.id).toBe(1);
  expect(observeTask(tasks, 'mill')?.id).toBe(5);
  expect(observeTask(tasks.slice(2, 5), 'barn')?.id).toBe(4);
  expect(observeTask(tasks, 'school')).toBeNull();
});
