import { describe, expect, it } from 'vitest';
import { type Alarm, alarmGlyph, alarmsOf, countWords, floodOf, groupsOf, isCalling } from './alarms';
import type { AskedQuestion, RecordedCommand, SignalWindow, Trouble } from './types';

const trouble = (kind: Trouble['kind'], t_ns: number, subject = 'x'): Trouble => ({
  t_ns,
  kind,
  subject,
  cause: 'why',
  task: 1,
  failed_child: null,
  handler_task: null,
  handler: null,
  place: null,
  target: null,
  targets: [],
  cause_kind: null,
});
const said = (alarm: string | null, t_ns: number, end = 'accepted'): RecordedCommand => ({
  t_ns,
  number: 1,
  words: `acknowledge ${alarm}`,
  end,
  reason: null,
  alarm,
});
const alarms = (
  troubles: Trouble[],
  commands: RecordedCommand[],
  atNs = 100e9,
  windows: SignalWindow[] = [],
  questions: AskedQuestion[] = [],
) =>
  alarmsOf(
    troubles,
    questions,
    windows,
    commands,
    atNs,
    one => one.subject,
    one => one.attribute,
  );

describe('alarms', () => {
  it('are open questions, which an answer or the end of their time settles', () => {
    const asked: AskedQuestion = {
      question: 0,
      task: 7,
      text: 'Which?',
      options: ['a', 'b'],
      default: 'b',
      asked_ns: 10e9,
      by_ns: 40e9,
      closed_ns: 40e9,
      ended: { how: 'default', answer: 'b' },
    };
    const list = (atNs: number, one = asked) => alarms([], [], atNs, [], [one]);
    expect(list(9e9)).toEqual([]);
    const [open] = list(39e9);
    expect([open?.words, open?.cause, open?.open, open?.acknowledgedNs, open?.settled]).toEqual([
      'question: Which?',
      'one of a, b; by T+0:00:40, then b',
      true,
      null,
      null,
    ]);
    const [over] = list(40e9);
    expect([over?.open, over?.acknowledgedNs, over?.settledNs, over?.settled]).toEqual([
      false,
      null,
      40e9,
      'default b taken',
    ]);
    const settled = (ended: AskedQuestion['ended']) =>
      list(40e9, { ...asked, closed_ns: 12e9, ended }).map(one => [one.settledNs, one.settled]);
    expect(settled({ how: 'answered', answer: 'a', author: 'ann' })).toEqual([[12e9, 'answered a by ann']]);
    expect(settled({ how: 'answered', answer: 'a', author: null })).toEqual([[12e9, 'answered a']]);
    const reason = 'its task was interrupted';
    expect(settled({ how: 'withdrawn', reason })).toEqual([[12e9, `withdrawn: ${reason}`]]);
    expect(settled({ how: 'task-ended' })).toEqual([[12e9, 'its task ended']]);
    // No operator has acknowledged a question that is over, but it no longer calls one.
    expect(over && [isCalling(over), countWords([over])]).toEqual([
      false,
      '1 alarm, 0 not acknowledged, 1 question over',
    ]);
    expect(open && isCalling(open)).toBe(true);
  });

  it('are raised once for each cause and count repeats, and interruptions are none', () => {
    const list = alarms([trouble('failed', 1e9), trouble('failed', 5e9), trouble('interrupted', 6e9)], []);
    expect(list.map(one => [one.words, one.count, one.lastNs])).toEqual([['failed: x', 2, 5e9]]);
  });

  it('are known only from their time on', () => {
    expect(alarms([trouble('failed', 8e9)], [], 7e9)).toEqual([]);
  });

  it('are acknowledged by an accepted command, until they are raised again', () => {
    const id = 'failed: x (T+0:00:01)';
    expect(alarms([trouble('failed', 1e9)], [said(id, 3e9)])[0]?.acknowledgedNs).toBe(3e9);
    expect(alarms([trouble('failed', 1e9)], [said(id, 3e9, 'rejected')])[0]?.acknowledgedNs).toBeNull();
    const again = alarms([trouble('failed', 1e9), trouble('failed', 4e9)], [said(id, 3e9)])[0];
    expect(again?.acknowledgedNs).toBeNull();
    expect(again && alarmGlyph(again)).toBe('▲');
    // A message that contains the words of an acknowledgement is none.
    const message = { ...said(null, 3e9), words: `message: (say "acknowledge ${id}")` };
    expect(alarms([trouble('failed', 1e9)], [message])[0]?.acknowledgedNs).toBeNull();
  });

  it('include excursions that the executive answered', () => {
    const window = {
      name: '(roll a)',
      attribute: 'roll',
      unit: 'deg',
      limits: [{ low: null, high: 3, duration_s: 5, also: '', guarded: true, step: 'refly', place: '' }],
      excursions: [
        { limit: 0, from_ns: 10e9, to_ns: 16e9, peak: 17.48321, samples: 6, raised_ns: 15e9 },
        { limit: 0, from_ns: 20e9, to_ns: 21e9, peak: 4, samples: 1, raised_ns: null },
      ],
    } as unknown as SignalWindow;
    const [one, ...rest] = alarms([], [], 100e9, [window]);
    expect(rest).toEqual([]);
    expect([one?.words, one?.cause]).toEqual([
      'roll beyond its limit',
      'peak 17.48 deg, 6.0 s, watched by refly',
    ]);
  });
});

describe('a flood', () => {
  const alarm = (number: number, minutes: number, cause: string, group = 'left-out'): Alarm => ({
    id: `a${number}`,
    words: `left out: target ${number}`,
    cause,
    group,
    firstNs: minutes * 60e9,
    lastNs: minutes * 60e9,
    count: 1,
    open: false,
    isQuestion: false,
    acknowledgedNs: null,
    settled: null,
    settledNs: null,
    task: null,
    target: `t${number}`,
    signal: null,
  });
  const ten = Array.from({ length: 10 }, (_, at) => alarm(at, 20 - at * 0.5, `needs ${at + 1} min more`));

  it('is ten alarms in ten minutes without acknowledgement, and the first one leads', () => {
    expect(floodOf(ten, 20 * 60e9)?.map(one => one.id)[0]).toBe('a9');
    expect(floodOf(ten.slice(1), 20 * 60e9)).toBeNull();
    // Ten minutes later the oldest alarm no longer counts, and an acknowledged one never does.
    expect(floodOf(ten, 25.5 * 60e9)).toBeNull();
    expect(
      floodOf([...ten.slice(1), { ...alarm(0, 20, ''), acknowledgedNs: 21 * 60e9 }], 21 * 60e9),
    ).toBeNull();
  });

  it('is listed by cause, whatever the figures', () => {
    const failed = (number: number) =>
      alarm(number, 1, `T${number} failed: no path`, 'failed child-failed a:3:1');
    const groups = groupsOf([...ten, failed(11), failed(12)]);
    expect(groups.map(group => group.alarms.length)).toEqual([10, 2]);
    expect(groups[0]?.cause).toBe('needs 1 min more');
  });

  it('has one group for one kind of cause at one place of the program', () => {
    const entry = (subject: string, cause_kind: string, place: string, cause: string): Trouble => ({
      ...trouble('failed', 1e9, subject),
      cause_kind,
      place,
      cause,
    });
    const list = alarms(
      [
        entry('a', 'child-failed', 'a.pdl:3:1', 'its child failed'),
        entry('b', 'child-failed', 'a.pdl:3:1', 'worded otherwise'),
        entry('c', 'child-failed', 'a.pdl:9:1', 'its child failed'),
        entry('d', 'duration-elapsed', 'a.pdl:3:1', 'its child failed'),
      ],
      [],
    );
    const groups = groupsOf(list).map(group => group.alarms.map(one => one.words));
    expect(groups).toEqual([['failed: a', 'failed: b'], ['failed: c'], ['failed: d']]);
  });
});
