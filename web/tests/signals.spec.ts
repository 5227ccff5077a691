/** The signals panel compared with the record, as read by `apex trace` with code that the page's server does not use. */

import { execFileSync } from 'node:child_process';
import { readFileSync } from 'node:fs';
import { expect, type Page, test } from '@playwright/test';
import { COLOURS } from '../src/theme/colours';
import { expectNoFaults } from './axe';
import { countColours } from './pixels';
import { apexProgram, type Server, startServer } from './server';

const RECORD = process.env.APEX_RECORD ?? '';
const ROLL = '(roll-angle aircraft-1)';

let server: Server;

test.beforeAll(async () => {
  server = await startServer();
});
test.afterAll(() => server?.stop());

/** Lines of `apex trace` of the record, as JSON. */
function trace(...options: string[]): { t: number; [member: string]: unknown }[] {
  const text = execFileSync(apexProgram(), ['trace', RECORD, '--json', ...options], {
    encoding: 'utf8',
    maxBuffer: 1 << 28,
  });
  return text
    .split('\n')
    .filter(Boolean)
    .map(line => JSON.parse(line));
}

/** Roll angles in degrees, recorded between two times in seconds. */
function rolls(fromS: number, toS: number): number[] {
  const options = ['--type', 'measurement', '--object', ROLL, '--from', `${fromS}s`, '--to', `${toS}s`];
  return trace(...options).map(line => Number(/(-?[\d.]+(?:e-?\d+)?)/.exec(String(line.value))?.[1]));
}

/** When the mission answered a roll beyond its limit, in seconds. */
function answered(): number[] {
  const lines = trace('--type', 'satisfied');
  return lines.filter(line => JSON.stringify(line).includes(ROLL)).map(line => line.t);
}

function plot(page: Page, name: string) {
  return page.locator(`[data-signal="${name}"]`);
}

function number(text: string | null): number {
  return Number(/-?[\d.]+/.exec(text ?? '')?.[0]);
}

test('a signal shows its limit, the answered excursion, the value and the statistics of the record', async ({
  page,
}) => {
  const times = answered();
  test.skip(times.length === 0, 'needs a flight with an answered roll');
  const at = Math.floor(times[0] ?? 0) + 30;
  const from = at - 120;
  await page.goto(`${server.url}/?t=${at}&w=${from}-${at + 120}&tab=signals&strips=roll-angle+aircraft-1`);
  const roll = plot(page, 'roll-angle aircraft-1');
  await expect(roll.getByTestId('excursions')).toContainText('▲');
  await expect(roll).toContainText('limit: beyond ±3.00° for 5.0 s');
  const recorded = rolls(from, at);
  const facts = roll.getByTestId('statistics').locator('dd');
  await expect(facts.last()).toHaveText(String(recorded.length));
  expect(number(await facts.nth(0).textContent())).toBeCloseTo(Math.min(...recorded), 1);
  expect(number(await facts.nth(1).textContent())).toBeCloseTo(Math.max(...recorded), 1);
  expect(number(await roll.getByTestId('signal-now').textContent())).toBeCloseTo(recorded.at(-1) ?? 0, 1);
  const seen = await countColours(page, roll.locator('.plot'), [COLOURS.att, COLOURS.strip, COLOURS.band]);
  expect(seen[COLOURS.att], 'the excursion').toBeGreaterThan(10);
  expect(seen[COLOURS.strip], 'the line').toBeGreaterThan(30);
  expect(seen[COLOURS.band], 'the limit as a band').toBeGreaterThan(200);
});

test('nothing later than the cursor is drawn, counted or listed', async ({ page }) => {
  const times = answered();
  test.skip(times.length === 0, 'needs a flight with an answered roll');
  const at = Math.floor(times[0] ?? 0) - 30;
  const from = at - 120;
  await page.goto(`${server.url}/?t=${at}&w=${from}-${at + 120}&tab=signals&strips=roll-angle+aircraft-1`);
  const roll = plot(page, 'roll-angle aircraft-1');
  await expect(roll.getByTestId('statistics').locator('dd').last()).toHaveText(
    String(rolls(from, at).length),
  );
  await expect(roll).not.toContainText('▲');
  const box = await roll.locator('.u-over').boundingBox();
  if (!box) throw new Error('no plot');
  const png = await page.screenshot({
    clip: { x: box.x + box.width / 2 + 3, y: box.y, width: box.width / 2 - 6, height: box.height },
  });
  const later = await page.evaluate(
    async ({ png, colour }) => {
      const image = new Image();
      image.src = `data:image/png;base64,${png}`;
      await image.decode();
      const canvas = new OffscreenCanvas(image.width, image.height);
      const context = canvas.getContext('2d');
      context?.drawImage(image, 0, 0);
      const data = context?.getImageData(0, 0, image.width, image.height).data ?? [];
      const wanted = [1, 3, 5].map(place => Number.parseInt(colour.slice(place, place + 2), 16));
      let count = 0;
      for (let place = 0; place < data.length; place += 4) {
        if (wanted.every((value, channel) => Math.abs((data[place + channel] ?? 0) - value) <= 10))
          count += 1;
      }
      return count;
    },
    { png: png.toString('base64'), colour: COLOURS.strip },
  );
  expect(later, 'pixels of the line right of the cursor').toBe(0);
});

test('a dragged range has the statistics of its samples, and the address keeps it', async ({ page }) => {
  await page.goto(`${server.url}/?t=20000&w=18000-20000&tab=signals&strips=roll-angle+aircraft-1`);
  const roll = plot(page, 'roll-angle aircraft-1');
  const over = roll.locator('.u-over');
  await expect(over).toBeVisible();
  await over.scrollIntoViewIfNeeded();
  const box = await over.boundingBox();
  if (!box) throw new Error('no plot');
  await page.mouse.move(box.x + box.width * 0.25, box.y + 30);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width * 0.5, box.y + 30, { steps: 4 });
  await page.mouse.up();
  await expect(page).toHaveURL(/range=18\d+/);
  const [, from, to] = /range=([\d.]+)-([\d.]+)/.exec(page.url()) ?? [];
  const recorded = rolls(Number(from), Number(to));
  const samples = roll.getByTestId('statistics').locator('dd').last();
  await expect
    .poll(async () => Math.abs(Number(await samples.textContent()) - recorded.length))
    .toBeLessThanOrEqual(1);
  await page.mouse.move(box.x + box.width * 0.75, box.y + 30);
  await expect(roll.getByTestId('pointed')).toContainText(/T\+5:2\d:\d\d.*°/);
  const shown = await page.getByTestId('range').textContent();
  await page.goto(page.url());
  await expect(page.getByTestId('range')).toHaveText(shown ?? '');
});

test('any variable can be added, words too, and what is shown is exported', async ({ page }) => {
  await page.goto(`${server.url}/?t=20000&tab=signals&strips=fuel+aircraft-1`);
  await expect(plot(page, 'fuel aircraft-1')).toBeVisible();
  await page.getByTestId('add-signal').selectOption({ label: 'flight phase' });
  await expect(plot(page, 'flight-phase aircraft-1').getByTestId('signal-now')).toHaveText(/[a-z]+/);
  await expect(page).toHaveURL(/strips=fuel\+aircraft-1,flight-phase\+aircraft-1/);
  const download = page.waitForEvent('download');
  await page.getByTestId('export-csv').click();
  const lines = readFileSync(await (await download).path(), 'utf8').split('\r\n');
  expect(lines[0]).toBe('signal,unit,time_s,value,lowest,highest,samples');
  const fuel = lines.filter(line => line.startsWith('(fuel aircraft-1),kg,'));
  const recorded = trace('--type', 'measurement', '--object', '(fuel aircraft-1)', '--to', '20000s');
  const exported = fuel.reduce((sum, line) => sum + Number(line.split(',').at(-1)), 0);
  expect(exported).toBe(recorded.length);
});

for (const theme of ['dark', 'light']) {
  test(`axe finds nothing on the signals, ${theme}`, async ({ page }) => {
    await page.goto(`${server.url}/?t=33000&tab=signals&theme=${theme}`);
    await expect(page.getByTestId('statistics').first()).toBeVisible();
    await expectNoFaults(page, 'signals');
  });
}
