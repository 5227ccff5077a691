import { describe, expect, it } from 'vitest';
import { Answers } from './answers';

describe('answers of the server', () => {
  it('are the same object while their text is the same', () => {
    const answers = new Answers();
    const first = answers.decode('targets?', '{"targets":[1]}');
    expect(first).toEqual({ targets: [1] });
    expect(answers.decode('targets?', '{"targets":[1]}')).toBe(first);
    const second = answers.decode('targets?', '{"targets":[2]}');
    expect(second).toEqual({ targets: [2] });
    expect(answers.decode('targets?', '{"targets":[1]}')).toEqual(first);
  });

  it('belong to their question', () => {
    const answers = new Answers();
    expect(answers.decode('why?task=1', '{}')).not.toBe(answers.decode('why?task=2', '{}'));
  });

  it('are kept for the last questions only', () => {
    const answers = new Answers();
    const [old, young] = [answers.decode('old', '{}'), answers.decode('young', '{}')];
    for (let task = 0; task < 63; task += 1) {
      expect(answers.decode('young', '{}')).toBe(young);
      answers.decode(`why?task=${task}`, '{}');
    }
    expect(answers.decode('old', '{}')).not.toBe(old);
  });

  it('that are not JSON fail', () => {
    expect(() => new Answers().decode('targets?', 'not JSON')).toThrow();
  });
});
