import { expect, it } from 'vitest';
import type { Mission } from '../../record/types';
import { headerView } from './view';

const mission: Mission = {
  mission: 'western-states',
  agent: 'pilot-1',
  vehicle: 'predator-b',
  apex_version: '0.1.0',
  record: 'flight.apex',
  epoch_utc: '2007-09-08T01:00:00Z',
  from_ns: 0,
  end_ns: 7200e9,
  end_reason: 'the root task ended',
  batches: 5,
  status: 'complete',
  tasks: 3,
  targets: 0,
  score: 0.876,
};

it('names the mission, its time and its score', () => {
  const view = headerView(mission, 60e9);
  expect(view.title).toBe('western-states');
  expect(view.subtitle).toBe('pilot-1 · predator-b');
  expect(view.time).toBe('T+0:01:00');
  expect(view.civil).toBe('2007-09-08 01:01:00Z');
  expect(view.score).toBe('0.88');
  expect(view.statusHelp).toContain('the root task ended');
});

it('falls back to the file name, and shows tenths in a short record', () => {
  const view = headerView({ ...mission, mission: null, agent: null, score: null, end_ns: 12e9 }, 1.26e9);
  expect(view.title).toBe('flight.apex');
  expect(view.subtitle).toBe('predator-b');
  expect(view.score).toBeNull();
  expect(view.time).toBe('T+0:00:01.2');
});
