import { expect, it } from 'vitest';
import { brief, phrase } from './phrase';

const names = new Map([
  ['butler-2', 'Butler 2'],
  ['ahorn', 'Ahorn'],
]);

it('names a goal by its words and targets, without arguments', () => {
  expect(phrase('(observe butler-2 along (((34.3 -116.9 5096.0))) due P3H2M)', names)).toBe(
    'observe Butler 2',
  );
  expect(phrase('(fly line from (47.6 -112.5 5323.0) to (47.5 -112.9 5323.0))', names)).toBe('fly line');
  expect(phrase('(weigh segment of ahorn from ?loc to (1 2) before (3 4))', names)).toBe(
    'weigh segment of Ahorn',
  );
  expect(phrase('(keep-in-touch over satellite-link)', names)).toBe('keep in touch over satellite link');
  expect(phrase('(take off to 7000m)', names)).toBe('take off to 7000m');
  expect(phrase('(terminate)', names)).toBe('terminate');
});

it('shortens sentences and keeps unmatched parentheses', () => {
  expect(brief('T7 (scan ahorn once along ((47.6 -112.5) ..)) started', names)).toBe('T7 scan Ahorn started');
  expect(brief('from (47.6 -112.5) on', names)).toBe('from … on');
  expect(brief('a ( b', names)).toBe('a ( b');
  expect(brief('T9 (regain communication at (44.3 ..) started', names)).toBe(
    'T9 regain communication at … started',
  );
});
