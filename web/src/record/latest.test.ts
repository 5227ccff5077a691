import { expect, it } from 'vitest';
import { LatestOnly } from './latest';

it('asks the newest of the questions that came while one was under way', async () => {
  const asked: number[] = [];
  const answers: number[] = [];
  const latest = new LatestOnly<number, number>(
    async question => {
      asked.push(question);
      await Promise.resolve();
      return question * 10;
    },
    answer => answers.push(answer),
    () => {},
  );
  for (const question of [1, 2, 3, 4]) latest.put(question);
  await new Promise(resolve => setTimeout(resolve, 5));
  expect(asked).toEqual([1, 4]);
  expect(answers).toEqual([10, 40]);
});

it('continues after an error', async () => {
  const errors: unknown[] = [];
  const answers: number[] = [];
  const latest = new LatestOnly<number, number>(
    question => (question === 1 ? Promise.reject(new Error('no')) : Promise.resolve(question)),
    answer => answers.push(answer),
    error => errors.push(error),
  );
  latest.put(1);
  await new Promise(resolve => setTimeout(resolve, 5));
  latest.put(2);
  await new Promise(resolve => setTimeout(resolve, 5));
  expect(errors).toHaveLength(1);
  expect(answers).toEqual([2]);
});
