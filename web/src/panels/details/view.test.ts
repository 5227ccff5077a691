import { describe, expect, it } from 'vitest';
import type { Cause, Why } from '../../record/types';
import { hasSource, logLines, reportView, snippetLines, toneOf, whyView, withoutPlace } from './view';

function cause(id: number, more: Partial<Cause> = {}): Cause {
  return {
    id,
    t_ns: id * 1e9,
    kind: 'transition',
    heading: 'started',
    task: 4,
    from_state: 'enabled',
    to_state: 'ongoing',
    outcome: null,
    subject: null,
    text: 'it needs no resources; from a.pdl:3:1',
    place: 'a.pdl:3:1',
    ...more,
  };
}

const why: Why = {
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
    method: 'primitive at a.pdl:9:1',
    place: 'a.pdl:3:1',
  },
  now: 'T4 is ongoing; because it needs no resources',
  because: [cause(1), cause(2)],
  left_out: false,
  children: [],
  explainer: null,
  explainer_error: null,
};

describe('why', () => {
  it('has the newest cause first, with its place as a link and not in the text', () => {
    const view = whyView(why, null);
    expect(view.causes.map(entry => entry.id)).toEqual([2, 1]);
    expect(view.causes[0]?.text).toBe('it needs no resources');
    expect(view.causes[0]?.place).toBe('a.pdl:3:1');
    expect(view.facts.find(fact => fact.name === 'for')?.value).toBe('1 min 00 s');
  });

  it('adds what the explainer says and passes over what it does not understand', () => {
    const waiting = [
      { what: '(on camera-1)', now: 'off', place: 'a.pdl:4:2' },
      { what: 'x' },
      3,
      { now: 'y' },
    ];
    const blocked = {
      by: 'T9',
      goal: '(pan)',
      resource: 'camera',
      strengths: '7 + interrupt cost 0.1 against 3',
    };
    const view = whyView({ ...why, explainer: { waiting, blocked } }, '2007-09-08T01:00:00Z');
    expect(view.sentences).toEqual([
      why.now,
      'camera is with T9 (pan), priority 7 + interrupt cost 0.1 against 3',
    ]);
    expect(view.waiting).toEqual([
      { what: '(on camera-1)', now: 'off', place: 'a.pdl:4:2' },
      { what: 'x', now: '', place: null },
    ]);
    expect(whyView({ ...why, explainer: { waiting: 5, blocked: 'no' } }, null).sentences).toEqual([why.now]);
    expect(view.facts[0]?.value).toBe('T+0:00:05 · 2007-09-08 01:00:05Z');
  });
});

it('the log names ends by their outcome, and trouble by its colour', () => {
  const lines = logLines([cause(1), cause(2, { outcome: 'failure', to_state: 'terminated' })]);
  expect(lines.map(line => line.what)).toEqual(['failure', 'ongoing']);
  expect(lines[0]?.tone).toBe('skipped');
  expect(toneOf(cause(3, { kind: 'refused' }))).toBe('interrupted');
  expect(withoutPlace('all is well', 'b:1:1')).toBe('all is well');
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
});

it('a snippet marks its place', () => {
  const lines = snippetLines({ name: 'a', line: 3, first_line: 2, lines: ['x', 'y'] });
  expect(lines[1]).toEqual({ number: 3, text: 'y', here: true });
  expect([hasSource('a.pdl:3:1'), hasSource('<plan 3>:1:1')]).toEqual([true, false]);
});
