import { expect, it } from 'vitest';
import { brief, eventWords, phrase, untilTarget } from './phrase';

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
  expect(phrase('(land home :course 3.14159265359rad :hold P13M18S :via ((85.9 9.8 550.0)))', names)).toBe(
    'land home',
  );
  expect(phrase('(take off to 7000m)', names)).toBe('take off to 7000m');
  expect(phrase('(terminate)', names)).toBe('terminate');
});

it('ends before the first argument that is left out, except for targets', () => {
  expect(phrase('(loiter at (34.3 -116.9) unless it is ?place)', names)).toBe('loiter');
  expect(phrase('(respond for terrain because ?why with margin ?m)', names)).toBe('respond for terrain');
  expect(phrase('(land home :course 3.14159265359rad :hold :via)', names)).toBe('land home');
  expect(phrase('(replan because "it is late")', names)).toBe('replan');
  expect(phrase('(fly from (34.3 -116.9) to ahorn)', names)).toBe('fly to Ahorn');
});

it('shortens purposes and messages', () => {
  expect(untilTarget('(photograph ahorn with camera-1 pointed at ahorn taking 1)', names)).toBe(
    'photograph Ahorn',
  );
  expect(untilTarget('(take off to 7000m)', names)).toBe('take off to 7000m');
  expect(
    eventWords('(segment-weighed ahorn (47.8 -112.9 5373.0) (47.8 -1) again 0.4 0.0 "the segment")', names),
  ).toBe('segment weighed Ahorn');
});

it('shortens sentences and keeps unmatched parentheses', () => {
  expect(brief('T7 (scan ahorn once along ((47.6 -112.5) ..)) started', names)).toBe('T7 scan Ahorn started');
  expect(brief('from (47.6 -112.5) on', names)).toBe('from … on');
  expect(brief('a ( b', names)).toBe('a ( b');
  expect(brief('T9 (regain communication at (44.3 ..) started', names)).toBe(
    'T9 regain communication at … started',
  );
});
