/**
 * What if: from the page, a recorded flight of structure-watch is continued with another wind, and both futures are compared. A plan is
 * drawn on the map, validated, and committed to a flight under way. All results are checked against the records.
 */

import { type ChildProcess, execFileSync, spawn } from 'node:child_process';
import { existsSync, mkdtempSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { expect, test } from '@playwright/test';
import type { ForkState, Operation } from '../src/record/types';
import { COLOURS } from '../src/theme/colours';
import { expectNoFaults } from './axe';
import { countColours } from './pixels';
import { addressOf, apexProgram, type Server, startServer } from './server';

const MISSION = fileURLToPath(new URL('../../missions/structure-watch', import.meta.url));
const folder = mkdtempSync(join(tmpdir(), 'sherpa-'));
const record = join(folder, 'watch.apex');
let server: Server;

// One flight for all tests of this file.
test.describe.configure({ mode: 'default' });
test.beforeAll(async () => {
  test.setTimeout(180_000);
  execFileSync(apexProgram(), ['fly', MISSION, '--record', record, '--no-progress'], { stdio: 'ignore' });
  server = await startServer(record);
});
test.afterAll(() => server?.stop());

function meta(path: string): string {
  return execFileSync(apexProgram(), ['replay', path]).toString();
}

test('a fork with other wind is flown from the page, and both futures stand side by side', async ({
  page,
}) => {
  test.setTimeout(180_000);
  await page.goto(`${server.url}/?t=600&tab=whatif`);
  await page.getByTestId('whatif-wind').fill('3');
  await page.getByTestId('whatif-begin').click();
  const fork = page.getByTestId('fork').first();
  await expect(fork).toContainText('wind times 3');
  await expect(fork.getByTestId('comparison')).toBeVisible({ timeout: 120_000 });
  await expectNoFaults(page, 'a fork has ended');
  const [state] = (await (await fetch(`${server.url}/api/forks`)).json()) as ForkState[];
  if (!state) throw new Error('the server lists no fork');
  expect(state.state).toBe('ended');
  expect(existsSync(state.file)).toBe(true);
  // The new record replays, and `apex fork` prints the same comparison.
  expect(meta(state.file)).toContain('confirmed');
  const again = join(folder, 'again.apex');
  const printed = execFileSync(apexProgram(), [
    'fork',
    record,
    '--at',
    '10min',
    '--wind-factor',
    '3',
    '--output',
    again,
  ]).toString();
  for (const line of (state.comparison ?? '').split('\n').filter(Boolean)) expect(printed).toContain(line);

  await fork.getByTestId('whatif-compare').click();
  await expect(page.getByTestId('compare-rows')).toBeVisible();
  await expect(page).toHaveURL(/vs=\d+/);
  // Before the instant the two flights are identical, and nothing differs. At the end something does.
  await expect(page.getByTestId('compare-rows').locator('text.differs')).toHaveCount(0);
  await page.keyboard.press('End');
  await expect
    .poll(() => page.getByTestId('compare-rows').locator('text.differs').count())
    .toBeGreaterThan(0);
  const map = await countColours(page, page.getByTestId('map'), [COLOURS.other]);
  expect(map[COLOURS.other] ?? 0, 'the other track on the map').toBeGreaterThan(20);
  await expectNoFaults(page, 'two futures');
});

test('a wrong message and a fork of an instant outside of the record are refused with their reason', async ({
  page,
}) => {
  await page.goto(`${server.url}/?t=600&tab=whatif`);
  await page.getByTestId('whatif-messages').fill('(new-value barn');
  await page.getByTestId('whatif-begin').click();
  await expect(page.getByTestId('whatif-error')).toContainText('is not a form of PDL');
  const post = (what: string, body: object) =>
    fetch(`${server.url}/api/${what}`, {
      method: 'POST',
      headers: { 'Content-Type': 'application/json' },
      body: JSON.stringify(body),
    });
  expect((await post('forks', { at_ns: 1, wind: 2 })).status).toBe(422);
  expect((await post('drafts', {})).status).toBe(422);
  const late = await post('forks', { at_ns: 9e15 });
  expect(late.status).toBe(422);
  expect(await late.text()).toContain('lies outside of the record');
  const foreign = await fetch(`${server.url}/api/forks`, {
    method: 'POST',
    headers: { 'Content-Type': 'application/json', Origin: 'https://example.com' },
    body: '{"at_ns": 1}',
  });
  expect(foreign.status).toBe(403);
  expect((await fetch(`${server.url}/api/records/99/mission`)).status).toBe(404);
});

test('a plan is drawn on the map, its violation is shown at the place, and it is committed to the flight', async ({
  page,
}) => {
  test.setTimeout(180_000);
  const path = join(folder, 'live.apex');
  const flight: ChildProcess = spawn(
    apexProgram(),
    ['fly', MISSION, '--serve', '--port', '0', '--no-progress', '--record', path, '--paused', '--pace', '60'],
    { stdio: ['ignore', 'pipe', 'pipe'] },
  );
  try {
    const url = await addressOf(flight);
    const operation = async () => (await (await fetch(`${url}/api/operation`)).json()) as Operation;
    await page.goto(`${url}/?left=draft`);
    await page.getByTestId('run-pause').click();
    await expect.poll(async () => (await operation()).now_ns, { timeout: 60_000 }).toBeGreaterThan(120e9);
    await page.getByTestId('run-pause').click();
    await expect(page.getByTestId('run-state')).toHaveText('paused');

    await page.getByTestId('draft-begin').click();
    const known = (await operation()).targets.filter(target => target.known).map(target => target.id);
    const [first, second] = known as [string, string];
    await page.getByTestId('draft-add').selectOption(first);
    await page.getByTestId('draft-add').selectOption(second);
    await expect(page.getByTestId('draft').getByRole('listitem')).toHaveCount(2);
    await page.getByTestId('draft-validate').click();
    await expect(page.getByTestId('draft-stage')).toHaveText('validated', { timeout: 30_000 });
    await expectNoFaults(page, 'a validated draft');
    await page.getByTestId('draft-commit').click();
    await expect(page.getByTestId('draft-stage')).toContainText('committed', { timeout: 30_000 });
    await page.getByTestId('run-pause').click();
    // The flight adopts a plan of exactly these visits, according to the record.
    await expect
      .poll(
        async () => {
          const plan = (await (await fetch(`${url}/api/plan`)).json()) as { visits: { target: string }[] };
          return plan.visits.map(visit => visit.target);
        },
        { timeout: 60_000 },
      )
      .toEqual([first, second]);
    await page.getByTestId('run-stop').click();
    await page.getByTestId('stop-confirm').click();
    await expect(page.getByTestId('operator')).toHaveCount(0);
    const trace = execFileSync(apexProgram(), ['trace', path, '--json'], { maxBuffer: 1 << 28 }).toString();
    expect(trace).toContain(`plan-imposed (${first} ${second})`);
    expect(meta(path)).toContain('confirmed');
  } finally {
    flight.kill('SIGKILL');
  }

  // A draft that cannot be flown names the impossible visit: here on the recorded flight, near its end.
  await page.goto(`${server.url}/?t=3000&left=draft`);
  await page.getByTestId('draft-from-plan').click();
  const map = page.getByTestId('map');
  const add = page.getByTestId('draft-add');
  for (let left = await add.locator('option').count(); left > 1; left -= 1)
    await add.selectOption({ index: 1 });
  await page.getByTestId('draft-validate').click();
  await expect(page.getByTestId('draft-violation')).toContainText(/cannot be made|there is no target/, {
    timeout: 30_000,
  });
  await expect(page.getByTestId('draft').locator('li.fault')).toHaveCount(1);
  const seen = await countColours(page, map, [COLOURS.att]);
  expect(seen[COLOURS.att] ?? 0, 'the violation is on the map').toBeGreaterThan(20);
  await expectNoFaults(page, 'a draft that cannot be flown');
});

test('an alarm is acknowledged by an operator, and the record holds it', async ({ page }) => {
  test.setTimeout(120_000);
  const path = join(folder, 'alarm.apex');
  const flight = spawn(
    apexProgram(),
    [
      'fly',
      MISSION,
      '--serve',
      '--port',
      '0',
      '--no-progress',
      '--record',
      path,
      '--paused',
      '--pace',
      '300',
    ],
    { stdio: ['ignore', 'pipe', 'pipe'] },
  );
  try {
    const url = await addressOf(flight);
    await page.goto(`${url}/?tab=alarms`);
    await page.getByTestId('run-pause').click();
    await expect(page.getByTestId('acknowledge').first()).toBeVisible({ timeout: 90_000 });
    await page.getByTestId('run-pause').click();
    await expect(page.getByTestId('run-state')).toHaveText('paused');
    const alarm = page.getByTestId('alarms').getByRole('listitem').first();
    const id = (await alarm.getAttribute('data-alarm')) ?? '?';
    await alarm.getByTestId('acknowledge').click();
    await expect(page.locator(`[data-alarm="${id}"]`)).toContainText('acknowledged');
    await page.getByTestId('run-stop').click();
    await page.getByTestId('stop-confirm').click();
    await expect(page.getByTestId('operator')).toHaveCount(0);
    const trace = execFileSync(apexProgram(), ['trace', path, '--json'], { maxBuffer: 1 << 28 }).toString();
    expect(trace).toContain(`acknowledge ${id}`);
  } finally {
    flight.kill('SIGKILL');
  }
});
