import { describe, expect, it } from 'vitest';
import type { Operation } from '../../record/types';
import {
  commandText,
  deadlineText,
  endText,
  lastCommands,
  paceText,
  runText,
  sentText,
  unheard,
  valueFault,
  wishWords,
} from './view';

const RUN: Operation = {
  now_ns: 0,
  clock_ms: 0,
  pace: 60,
  paused: false,
  questions: [],
  planning: null,
  targets: [],
  commands: [],
  authority: {
    epoch: 0,
    holder: null,
    silent: false,
    offer: null,
    you: { name: 'this-machine', role: 'pilot-in-command' },
    yours: false,
    may_take: true,
    stations: [],
  },
};
const SENT = {
  number: 1,
  words: 'pause',
  by: 'this-machine',
  at_ns: null,
  reason: null,
  age_s: 0.42,
} as const;

describe('operator bar', () => {
  it('says how the run stands', () => {
    expect(runText(RUN)).toBe('running, 60× real time');
    expect(runText({ ...RUN, pace: 0, paused: true })).toBe('paused');
    expect(runText({ ...RUN, pace: null })).toBe('running, as fast as possible');
    expect(runText({ ...RUN, planning: { goal: '(visit all)', since_s: 2.14 } })).toBe(
      'planning (visit all) for 2.1 s; mission time stands still',
    );
    expect(paceText(1)).toBe('real time');
  });

  it('gives every command one end, with its reason', () => {
    expect(endText({ ...SENT, state: 'sent' })).toBe('sent 0.4 s');
    expect(endText({ ...SENT, state: 'accepted' })).toBe('accepted');
    expect(endText({ ...SENT, state: 'rejected', reason: 'question 3 is not open' })).toBe(
      'rejected: question 3 is not open',
    );
  });

  it('keeps the own command apart from that of another station, which has its name', () => {
    const own = { ...SENT, number: 1, by: 'bob', state: 'rejected' as const, reason: 'ann holds authority' };
    const other = { ...SENT, number: 2, by: 'ann', state: 'accepted' as const };
    const authority = { ...RUN.authority, you: { name: 'bob', role: 'operator' as const } };
    const text = (commands: Operation['commands']) =>
      lastCommands({ commands, authority }).map(one => commandText(one, 'bob'));
    expect(text([own, other])).toEqual(['pause: rejected: ann holds authority', 'pause by ann: accepted']);
    expect(text([other, { ...own, number: 3 }])).toEqual(['pause: rejected: ann holds authority']);
    expect(text([other])).toEqual(['pause by ann: accepted']);
    expect(text([])).toEqual([]);
  });

  it('says how long a command waits for a silent server, and that it has expired', () => {
    const pause = { wish: { do: 'pause' as const }, sentMs: 1000, after: 3 };
    expect(sentText(pause, 4000)).toEqual({ words: 'pause: sent 3.0 s', state: 'sent' });
    expect(sentText(pause, 11_000)).toMatchObject({
      words: expect.stringMatching(
        /^pause: expired after 10 s: the server does not answer; .*is no longer carried out$/,
      ),
      state: 'expired',
    });
    const listed = (number: number) => ({
      authority: RUN.authority,
      commands: [{ ...SENT, number, state: 'sent' as const }],
    });
    expect(unheard([pause], listed(3))).toEqual([pause]);
    expect(unheard([pause], listed(4))).toEqual([]);
  });

  it('states commands in the words of the record', () => {
    expect(wishWords({ do: 'take-authority' })).toBe('take authority');
    expect(wishWords({ do: 'remove-target', target: 'winery' })).toBe('remove target winery');
    expect(wishWords({ do: 'value-target', target: 'winery', value: 777 })).toBe(
      'value of target winery: 777',
    );
  });

  it('names a value that is not one', () => {
    expect([valueFault('12.5'), valueFault(' 3 ')]).toEqual([null, null]);
    expect(valueFault('-5')).toBe('-5 is not a value: expected a number of 0 or more');
    expect(valueFault('abc')).toContain('abc is not a value');
  });

  it('counts down to the default', () => {
    const question = {
      agent: 'a',
      question: 1,
      text: '',
      options: [],
      default: 'fire',
      asked_ns: 0,
      by_ns: 90e9,
    };
    expect(deadlineText(question, 30e9)).toBe('fire is taken in 1 min 00 s');
    expect(deadlineText({ ...question, default: null }, 90e9)).toBe('its task fails now');
    expect(deadlineText({ ...question, by_ns: null }, 0)).toBe('no deadline');
  });
});
