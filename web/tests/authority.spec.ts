/** Two stations and one flight: authority is taken, offered from the list of stations, rejected, and handed over, and all of this is in
 * the record. */

import { type ChildProcess, execFileSync, spawn } from 'node:child_process';
import { mkdtempSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { type Browser, type BrowserContext, expect, type Page, test } from '@playwright/test';
import { expectNoFaults } from './axe';
import { addressOf, apexProgram } from './server';

const MISSION = fileURLToPath(new URL('../../missions/structure-watch', import.meta.url));

let url: string;
let record: string;
let flight: ChildProcess;

test.beforeAll(async () => {
  record = join(mkdtempSync(join(tmpdir(), 'sherpa-')), 'flight.apex');
  flight = spawn(
    apexProgram(),
    ['fly', MISSION, '--serve', '--port', '0', '--no-progress', '--record', record, '--paused'],
    { stdio: ['ignore', 'pipe', 'pipe'] },
  );
  url = await addressOf(flight);
});
test.afterAll(() => {
  flight?.kill('SIGKILL');
});

const contexts: BrowserContext[] = [];
// A page without its server would ask for it until the last test.
test.afterEach(() => Promise.all(contexts.map(context => context.close())));

/** A separate browser context with a session of this name. */
async function station(browser: Browser, name: string, role: string): Promise<Page> {
  const context = await browser.newContext();
  contexts.push(context);
  const page = await context.newPage();
  const answer = await page.request.post(`${url}/api/session`, { data: { name, role } });
  expect(answer.status()).toBe(201);
  await page.goto(url);
  await expect(page.getByTestId('authority')).toBeVisible();
  return page;
}

test('authority is taken, offered to a station of the list, refused, and handed over', async ({
  browser,
}) => {
  test.setTimeout(180_000);
  const tower = await station(browser, 'tower', 'operator');
  await tower.getByTestId('take').click();
  await expect(tower.getByTestId('authority')).toContainText('authority: you');
  // With only one station there is no other to choose, and the page shows that.
  await expect(tower.getByTestId('no-stations')).toHaveText('no other station is connected');

  const van = await station(browser, 'van', 'operator');
  await station(browser, 'guest', 'observer');
  await expect(van.getByTestId('authority')).toContainText('tower (operator)');
  await expect(van.getByTestId('take')).toHaveCount(0);
  await van.getByTestId('run-step').click();
  await expect(van.getByTestId('last-command')).toContainText('rejected: tower holds authority');

  const list = tower.getByTestId('offer-to');
  await expect(list.locator('option')).toHaveText(['offer to …', 'van (operator)']);
  await expectNoFaults(tower, 'the holder with a list of stations');
  await list.selectOption('van');
  await expect(van.getByTestId('authority')).toContainText(/offered to you for \d+ s/);
  await expectNoFaults(van, 'an offer of authority');
  await van.getByTestId('refuse').click();
  await expect(tower.getByTestId('authority')).not.toContainText('offered');
  await expect(tower.getByTestId('authority')).toContainText('authority: you');

  await list.selectOption('van');
  await van.getByTestId('take').click();
  await expect(tower.getByTestId('authority')).toContainText('van (operator)');
  await van.getByTestId('run-stop').click();
  await van.getByTestId('stop-confirm').click();
  await expect(van.getByTestId('operator')).toHaveCount(0);

  const trace = execFileSync(apexProgram(), ['trace', record, '--json'], { maxBuffer: 1 << 28 })
    .toString()
    .replaceAll('\\"', '"');
  for (const entry of [
    '(authority 1 "tower" operator taken)',
    '(authority 1 "tower" operator offered "van")',
    '(authority 1 "van" operator refused)',
    '(authority 2 "van" operator handed-over)',
  ])
    expect(trace).toContain(entry);
  execFileSync(apexProgram(), ['replay', record], { stdio: 'pipe' });
});
