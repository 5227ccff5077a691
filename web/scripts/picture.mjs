// Takes pictures of the page and of each panel: node scripts/picture.mjs RECORD|URL FOLDER [SECONDS OF MISSION TIME] [TARGET]
// APEX_BINARY serves the record; default is the release build of this repository.

import { spawn } from 'node:child_process';
import { once } from 'node:events';
import { existsSync } from 'node:fs';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { chromium } from '@playwright/test';
import { launchOptions } from '../tests/browser.mjs';

const [source, folder, seconds = '33432', target = 'castle-rock'] = process.argv.slice(2);
if (!source || !folder) {
  console.error('usage: node scripts/picture.mjs RECORD|URL FOLDER [SECONDS OF MISSION TIME] [TARGET]');
  process.exit(2);
}
/** Time for the map to load, and for answers that restore an instant. */
const [LOAD_MS, SETTLE_MS, WAIT_MS] = [4000, 2500, 120_000];
/** Panels of each slot, with the selection made before the picture. */
const LEFT = ['agenda', 'objects', 'program', 'network', 'draft'];
const RIGHT = ['why', 'monitors', 'signals', 'plans', 'log', 'alarms', 'whatif', 'compare', 'report'];
const SCREENS = [
  ['sherpa', 1280, 720, 'dark'],
  ['sherpa-light', 1280, 720, 'light'],
  ['sherpa-1920', 1920, 1080, 'dark'],
  ['sherpa-820', 820, 1180, 'dark'],
  ['sherpa-390', 390, 844, 'dark'],
];

const browser = await chromium.launch(launchOptions);
const page = await browser.newPage({ viewport: { width: 1280, height: 720 } });
const servers = [];
const base = source.startsWith('http') ? source.replace(/\/$/, '') : await served(source);

/** Serves a record; the address. */
async function served(record) {
  const program =
    process.env.APEX_BINARY ?? fileURLToPath(new URL('../../target/release/apex', import.meta.url));
  const server = spawn(program, ['serve', record, '--port', '0'], { stdio: ['ignore', 'pipe', 'inherit'] });
  servers.push(server);
  const [said] = await once(server.stdout, 'data');
  return /https?:\/\/[^\s/]+/.exec(String(said))[0];
}

/** The active task at the instant, which the line "now" names. */
await page.goto(`${base}/?t=${seconds}`);
await page.getByTestId('now-task').click();
await page.waitForURL(/sel=task/);
const task = new URL(page.url()).searchParams.get('sel');

for (const [name, width, height, theme] of SCREENS) {
  await page.setViewportSize({ width, height });
  await page.goto(`${base}/?t=${seconds}&sel=${task}&theme=${theme}`);
  await page.waitForTimeout(LOAD_MS);
  await page.screenshot({ path: join(folder, `${name}.png`) });
}
await page.setViewportSize({ width: 1280, height: 900 });
const part = async (name, locator) => {
  await page.waitForTimeout(SETTLE_MS);
  await locator.screenshot({ path: join(folder, `panel-${name}.png`) });
};
for (const panel of [...LEFT, ...RIGHT]) {
  const slot = LEFT.includes(panel) ? 'left' : 'right';
  await page.goto(`${base}/?t=${seconds}&sel=${task}&${slot === 'left' ? 'left' : 'tab'}=${panel}`);
  await page.getByTestId(`tab-${panel}`).waitFor();
  if (panel === 'draft') await page.getByTestId('draft-from-plan').click();
  if (panel === 'report') await page.keyboard.press('End');
  // These panels wait until the server has restored the instant.
  if (panel === 'monitors') await page.getByTestId('monitors').waitFor({ timeout: WAIT_MS });
  if (panel === 'objects')
    await page.getByTestId('objects').getByText('flight-path').waitFor({ timeout: WAIT_MS });
  await part(panel, page.getByTestId(`slot-${slot}`));
}
await page.goto(`${base}/?t=${seconds}&sel=target:${target}`);
await part('map', page.getByTestId('map'));
for (const rows of ['all', 'resources']) {
  await page.goto(`${base}/?t=${seconds}&rows=${rows}&sel=${task}`);
  await part(`timeline-${rows}`, page.getByTestId('timeline').locator('..'));
}
await page.goto(`${base}/?print=1&t=${seconds}`);
await page.getByTestId('paper').waitFor({ timeout: 60_000 });
await part('paper', page.getByTestId('paper'));
// Two futures of a short flight, if its record is next to the other.
const short = join(source, '..', 'structure-watch.apex');
if (existsSync(short)) {
  const watch = await served(short);
  await page.goto(`${watch}/?t=600&tab=whatif`);
  await page.getByTestId('whatif-wind').fill('3');
  await page.getByTestId('whatif-begin').click();
  await page.getByTestId('comparison').waitFor({ timeout: WAIT_MS });
  await part('whatif', page.getByTestId('slot-right'));
  await page.getByTestId('whatif-compare').click();
  await page.getByTestId('compare-rows').waitFor();
  await page.keyboard.press('End');
  await part('compare', page.getByTestId('slot-right'));
}
await browser.close();
for (const server of servers) server.kill('SIGTERM');
