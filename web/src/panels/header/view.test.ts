import { expect, it } from 'vitest';
import type { Mission } from '../../record/types';
import { headerView, scoreSoFar } from './view';

const mission: Mission = {
  mission: 'western-states',
  agent: 'pilot-1',
  vehicle: 'predator-b',
  apex_version: '0.1.0',
  record: 'flight.apex',
  epoch_utc: '2007-09-08T01:00:00Z',
  from_ns: 0,
  end_ns: 7200e9,
  ending: { reason: 'the root task ended', failed: false },
  batches: 5,
  status: 'complete',
  tasks: 3,
  targets: 0,
  observed: 0,
  score: 0.876,
  score_kind: null,
};

it('names the mission, its time and its score', () => {
  const view = headerView(mission, 60e9);
  expect(view.statusText).toBe('ended');
  expect(view.title).toBe('western-states');
  expect(view.subtitle).toBe('pilot-1 · predator-b');
  expect(view.time).toBe('T+0:01:00');
  expect(view.civil).toBe('2007-09-08 01:01:00Z');
  expect(view.score).toBe('0.88');
  expect(view.statusHelp).toContain('the root task ended');
});

it('names a cost as a cost, and states the length of the mission as planned', () => {
  const cost = { ...mission, score: 293.4, score_kind: 'expected-cost-of-ignorance' };
  expect(headerView(cost, 60e9)).toMatchObject({
    score: '293',
    scoreName: 'expected cost of ignorance',
    length: '/ 2:00:00',
  });
  expect(headerView(mission, 60e9, false, 86_400e9)).toMatchObject({
    scoreName: 'score',
    length: 'of 24:00:00',
  });
});

it('falls back to the file name, and shows tenths in a short record', () => {
  const view = headerView({ ...mission, mission: null, agent: null, score: null, end_ns: 12e9 }, 1.26e9);
  expect(view.title).toBe('flight.apex');
  expect(view.subtitle).toBe('predator-b');
  expect(view.score).toBeNull();
  expect(view.time).toBe('T+0:00:01.2');
});

it('shows a failure, an unfinished record and the distance from the live end', () => {
  const failed = { ...mission, ending: { reason: 'the initial task failed', failed: true } };
  expect(headerView(failed, 7200e9)).toMatchObject({
    status: 'failed',
    statusText: '▲ failed: the initial task failed',
  });
  const unended: Mission = { ...mission, ending: null, score: null, targets: 22, observed: 3 };
  expect(headerView(unended, 0)).toMatchObject({ status: 'recorded', score: null });
  expect(headerView(unended, 0).progress).toBe('3 of 22 targets observed');
  const broken: Mission = { ...unended, status: 'incomplete' };
  expect(headerView(broken, 7200e9).statusText).toBe('▲ incomplete: record stops at T+2:00:00');
  const live: Mission = { ...unended, status: 'live' };
  expect(headerView(live, 7200e9, true).statusText).toBe('live');
  // Without a connection it is not known whether the flight is live.
  expect(headerView(live, 7200e9, true, null, false)).toMatchObject({
    status: 'incomplete',
    statusText: 'no connection, known until T+2:00:00',
  });
  expect(headerView(live, 7080e9).statusText).toBe('live, 2 min 00 s behind');
});

it('shows the score of an instant at that instant alone', () => {
  const score = { counted_ns: 3_600e9, benefits: 250.4, costs: 50.25, score: 200.15 };
  const known = { atNs: 3_660e9, score };
  expect(scoreSoFar(known, 3_660e9, 0)).toMatchObject({ text: '200' });
  expect(scoreSoFar(known, 3_660e9, 0)?.help).toContain(
    '250 points of observations until T+1:00:00, less costs of 50.3',
  );
  // Not earlier, because the score was not known then, and not much later, because it is not the score of that instant.
  expect(scoreSoFar(known, 3_659e9, 0)).toBeNull();
  expect(scoreSoFar(known, 3_800e9, 0)).toBeNull();
  expect(scoreSoFar(known, 3_800e9, 600)).not.toBeNull();
  expect(scoreSoFar(null, 0, 0)).toBeNull();
});
