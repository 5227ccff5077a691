import { describe, expect, it } from 'vitest';
import type { AskedQuestion } from '../../record/types';
import { deadline, openAt } from './view';

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

describe('open questions', () => {
  it('are those asked by then and not yet closed', () => {
    const open = (atNs: number) => openAt([asked], atNs).length;
    expect([9e9, 10e9, 39e9, 40e9].map(open)).toEqual([0, 1, 1, 0]);
    expect(openAt([{ ...asked, closed_ns: null, ended: null }], 90e9).length).toBe(1);
  });

  it('say what happens without an answer', () => {
    expect(deadline(asked, 15e9)).toBe('at T+0:00:40, in 25 s, b is taken');
    expect(deadline({ ...asked, default: null }, 39.5e9)).toBe('at T+0:00:40, now, its task fails');
    expect(deadline({ ...asked, by_ns: null }, 15e9)).toBe('no deadline');
  });
});
