/**
 * Tasks of an operator on the flight over the western states: the knowledge at an instant, dense intervals, failures, links. Needs a
 * record of that mission; on other records only the tasks possible on any record are checked.
 */

import { execFileSync } from 'node:child_process';
import { existsSync, mkdtempSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { expect, type Page, test } from '@playwright/test';
import { unpackRows } from '../src/record/bands';
import type { Mission, PlanInForce, ScoreSoFar, Targets, Timeline, Troubles } from '../src/record/types';
import { COLOURS } from '../src/theme/colours';
import { expectNoFaults } from './axe';
import { countColours } from './pixels';
import { apexProgram, type Server, startServer } from './server';

/** Sizes of screens on which no parts of the page may overlap. */
const SCREENS = [
  [1920, 1080],
  [1280, 720],
  [820, 1180],
  [390, 844],
] as const;

let server: Server;
let mission: Mission;

test.beforeAll(async () => {
  server = await startServer();
  mission = await ask('mission');
});
test.afterAll(() => server?.stop());

async function ask<T>(what: string): Promise<T> {
  const response = await fetch(`${server.url}/api/${what}`);
  expect(response.ok, `${what}: ${response.status}`).toBe(true);
  return response.json() as Promise<T>;
}

async function open(page: Page, address = ''): Promise<void> {
  await page.goto(`${server.url}/${address}`);
  // Narrow screens show another part first.
  await expect(page.locator('[data-task]').first()).toBeAttached();
}

const western = () => test.skip(mission.mission !== 'Western States Fire Mission', 'needs western-states');

test('at T+0 nothing is shown that was known later', async ({ page }) => {
  western();
  await open(page);
  await expect(page.getByTestId('time')).toContainText('T+0:00:00');
  await expect(page.getByTestId('score')).toHaveCount(0);
  await expect(page.getByTestId('status')).toHaveText('recorded');
  await expect(page.getByTestId('progress')).toHaveText('0 of 22 targets observed');
  // Length of the mission as planned, not of the flight that is still to come.
  await expect(page.getByTestId('length')).toHaveText('of 24:00:00');
  await expect(page.getByTestId('legend-known')).toHaveText('22');
  await expect(page.getByTestId('troubles')).toHaveText('▲ 0'); // english: allow
  await expect(page.getByTestId('agenda')).not.toContainText('domke-lake');
  await page.getByTestId('tab-report').click();
  await expect(page.getByTestId('report')).toContainText('The report belongs to the end of the flight.');
  const map = await countColours(page, page.getByTestId('map'), [COLOURS.flown]);
  expect(map[COLOURS.flown] ?? 0, 'flown track on the map').toBeLessThan(20);

  await open(page, '?t=10801');
  await expect(page.getByTestId('progress')).toContainText('of 23 targets');
  await open(page, '?t=18001');
  await expect(page.getByTestId('progress')).toContainText('of 24 targets');
  // The score so far is computed from the record's steps until then; at the end the report's score replaces it.
  const soFar = await ask<ScoreSoFar>('score?at=18001000000000');
  const last = await ask<ScoreSoFar>(`score?at=${mission.end_ns}`);
  expect(soFar.score).toBeLessThan(last.score);
  expect(last.score).toBeCloseTo(mission.score ?? Number.NaN, 6);
  await expect(page.getByTestId('score-so-far')).toHaveText(soFar.score.toFixed(0));
  await page.keyboard.press('End');
  await expect(page.getByTestId('score-so-far')).toHaveCount(0);
  await expect(page.getByTestId('score')).toHaveText(String(mission.score?.toFixed(0)));
});

test('a target is skipped since the first plan that left it out', async ({ page }) => {
  western();
  const { targets } = await ask<Targets>(`targets?at=${mission.end_ns}`);
  const skipped = targets.find(target => target.state === 'skipped');
  if (!skipped) throw new Error('the flight has observed every target');
  const before = skipped.history.map(change => change.state).findLastIndex(state => state !== 'skipped');
  const since = skipped.history[before + 1]?.t_ns ?? Number.NaN;
  expect(skipped.since_ns).toBe(since);
  const seconds = Math.floor(since / 1e9);
  const two = (number: number) => String(number).padStart(2, '0');
  await open(page, `?t=${seconds + 60}&sel=target:${skipped.id}`);
  const shown = `T+${Math.floor(seconds / 3600)}:${two(Math.floor(seconds / 60) % 60)}:${two(seconds % 60)}`;
  await expect(page.getByTestId('target-card')).toContainText(shown);
});

test('the timeline counts what it merges, and zooming shows it', async ({ page }) => {
  western();
  const end = mission.end_ns;
  const whole = await ask<Timeline>(`timeline?from=0&to=${end}&at=${end}&lanes=60&px=700`);
  expect(whole.more.lanes).toBeGreaterThan(0);
  const { troubles } = await ask<Troubles>(`troubles?at=${end}`); // english: allow
  // The re-flights come late in the flight, where the zoom to the whole flight merges the lanes; the last interruption is one.
  const refly = troubles.findLast(trouble => trouble.kind === 'interrupted');
  if (!refly) throw new Error('the flight has no interrupted task');
  const atS = refly.t_ns / 1e9;
  const asked = page.waitForRequest(
    request =>
      request.url().includes('/api/timeline') &&
      request.url().includes(`from=${Math.round((atS - 300) * 1e9)}`),
  );
  await open(page, `?t=${atS + 200}&w=${atS - 300}-${atS + 300}&sel=task:${refly.task}`);
  await asked;
  const near = await ask<Timeline>(
    `timeline?from=${Math.round((atS - 300) * 1e9)}&to=${Math.round((atS + 300) * 1e9)}&at=${Math.round((atS + 200) * 1e9)}&lanes=60`,
  );
  expect(
    near.lanes.flatMap(lane => unpackRows(lane.rows).flat()).some(bar => bar.state === 'interrupted'),
  ).toBe(true);
  const timeline = page.getByTestId('timeline');
  await expect
    .poll(async () => (await countColours(page, timeline, [COLOURS.interrupted]))[COLOURS.interrupted] ?? 0)
    .toBeGreaterThan(20);
});

test('n and N go to the next and previous failure or fault', async ({ page }) => {
  const { troubles } = await ask<Troubles>(`troubles?at=${mission.end_ns}`); // english: allow
  test.skip(troubles.length < 2, 'needs a flight with failures or faults');
  await open(page);
  const time = page.getByTestId('time');
  await page.keyboard.press('n');
  await expect(time).not.toContainText('T+0:00:00');
  const first = (await time.textContent()) ?? '';
  await expect(page.getByTestId('troubles')).not.toHaveText('▲ 0'); // english: allow
  await page.keyboard.press('n');
  await expect(time).not.toHaveText(first);
  await page.keyboard.press('N');
  await expect(time).toHaveText(first);
});

test('U1 to U3: the address holds instant, window and selection, and Back undoes a selection', async ({
  page,
}) => {
  await open(page);
  const [one, two] = [page.locator('[data-task]').nth(0), page.locator('[data-task]').nth(1)];
  await one.click();
  await expect(page).toHaveURL(/sel=task:\d+/);
  const first = page.url();
  await two.click();
  await expect(page).not.toHaveURL(first);
  await page.goBack();
  await expect(page).toHaveURL(first);
  await expect(one).toHaveAttribute('aria-selected', 'true');
  await page.keyboard.press('+');
  // In the agenda, which has the focus after the press on a task, the arrow keys are those of the tree (K2).
  await page.getByTestId('timeline').focus();
  await page.keyboard.press('ArrowRight');
  await expect(page).toHaveURL(/t=[\d.]+.*w=[\d.]+-[\d.]+|w=.*t=/);
  const [url, time] = [page.url(), await page.getByTestId('time').textContent()];
  const other = await page.context().newPage();
  await other.goto(url);
  await expect(other.getByTestId('time')).toHaveText(time ?? '');
  await expect(other.locator('[aria-selected="true"][data-task]')).toHaveCount(1);
  await other.close();

  await open(page, '?t=noon');
  await expect(page.getByRole('alert')).toContainText(
    'The address has t=noon; expected seconds of mission time',
  );
});

test('a failed flight looks failed at its end, and not before', async ({ page }) => {
  const folder = mkdtempSync(join(tmpdir(), 'sherpa-'));
  const [program, inputs, record] = ['order.pdl', 'inputs.jsonl', 'failed.apex'].map(name =>
    join(folder, name),
  );
  if (!program || !inputs || !record) throw new Error('no folder for the record');
  writeFileSync(
    program,
    `(procedure (index (do-domain)) (step ask (order) (waitfor (go))))
     (procedure (index (order)) (step no (terminate failure)))`,
  );
  writeFileSync(inputs, '{"t": 20, "event": "(go)"}');
  try {
    execFileSync(apexProgram(), ['run', program, '--inputs', inputs, '--record', record], {
      stdio: 'ignore',
    });
  } catch {
    // A run that fails is reported by its exit status.
  }
  const failed = await startServer(record);
  try {
    await page.goto(failed.url);
    await expect(page.getByTestId('status')).toHaveText('recorded');
    await page.keyboard.press('End');
    await expect(page.getByTestId('status')).toHaveText('▲ failed: the initial task failed');
    const colour = await page.getByTestId('status').evaluate(node => getComputedStyle(node).color);
    expect(colour).toBe('rgb(255, 138, 101)');
    await expect(page.getByTestId('troubles')).not.toHaveText('▲ 0'); // english: allow
  } finally {
    failed.stop();
  }
});

/** Serves another record of the flights, if it is there. */
async function withFlight(name: string, use: (url: string) => Promise<void>): Promise<void> {
  const record = join(dirname(process.env.APEX_RECORD ?? ''), `${name}.apex`);
  test.skip(!existsSync(record), `needs ${record}: make flights`);
  const other = await startServer(record);
  try {
    await use(other.url);
  } finally {
    other.stop();
  }
}

test('the axis has the planned length of the mission, not that of the flight', async ({ page }) => {
  await withFlight('diagnosis', async url => {
    const { end_ns } = (await (await fetch(`${url}/api/mission`)).json()) as Mission;
    const { duration_ns } = (await (await fetch(`${url}/api/facts`)).json()) as { duration_ns: number };
    expect(end_ns).toBeLessThan(duration_ns * 0.9);
    await page.goto(`${url}/?t=${duration_ns / 4e9}`);
    const axis = await page.getByTestId('timeline').boundingBox();
    const cursor = await page.getByTestId('cursor').boundingBox();
    if (!axis || !cursor) throw new Error('no timeline');
    const share = (cursor.x - axis.x - 168) / (axis.width - 168);
    expect(Math.abs(share - 0.25), `the cursor is at ${share}`).toBeLessThan(0.01);
  });
});

test('visits of a mission that watches structures are planned in mission time', async ({ page }) => {
  await withFlight('structure-watch', async url => {
    const at = 1500;
    const plan = (await (await fetch(`${url}/api/plan?at=${at}000000000`)).json()) as PlanInForce;
    const adoptedMin = Math.floor(plan.adopted_ns / 60e9);
    expect(adoptedMin).toBeGreaterThan(10);
    await page.goto(`${url}/?t=${at}&rows=targets`);
    await expect(page.locator('[data-target]').first()).toBeVisible();
    const minutes = async () =>
      (await page.locator('[data-target] svg text').allTextContents()).flatMap(text => {
        const [, hours, rest] = /^(\d+):(\d\d)$/.exec(text.trim()) ?? [];
        return rest ? [Number(hours) * 60 + Number(rest)] : [];
      });
    await expect.poll(async () => (await minutes()).length).toBeGreaterThan(3);
    for (const minute of await minutes()) expect(minute).toBeGreaterThanOrEqual(adoptedMin);
    // A target of the plan in force is not shown as left out, and the legend counts as many observed targets as the header.
    const planned = new Set(plan.visits.map(visit => visit.target));
    for (const target of planned)
      await expect(page.locator(`[data-target="${target}"]`)).not.toContainText('left out');
    const { observed } = (await (await fetch(`${url}/api/mission?at=${at}000000000`)).json()) as Mission;
    await expect(page.getByTestId('progress')).toContainText(`${observed} of `);
    await expect(page.getByTestId('legend-observed')).toHaveText(String(observed));
  });
});

test('narrow screens show one part at a time', async ({ page }) => {
  await page.setViewportSize({ width: 390, height: 844 });
  await open(page, '?t=40000');
  const parts = [
    ['map', page.getByTestId('map')],
    ['time', page.getByTestId('timeline')],
    ['agenda', page.getByTestId('slot-left')],
    ['why', page.getByTestId('slot-right')],
  ] as const;
  for (const [shown] of parts) {
    await page.getByTestId(`part-${shown}`).click();
    for (const [name, part] of parts) await expect(part).toBeVisible({ visible: name === shown });
    await expectNoFaults(page, `the part ${shown}`);
  }
  // The explanation of a selected task is in the part "why".
  await page.getByTestId('part-agenda').click();
  await page.locator('[data-task]').nth(1).click();
  await expect(page.getByTestId('why')).toBeVisible();
  await page.setViewportSize({ width: 820, height: 1180 });
  for (const [, part] of parts) await expect(part).toBeVisible();
  await expect(page.getByTestId('part-map')).toBeHidden();
});

test('all targets, three strips and nine lanes are visible at 1280x720', async ({ page }) => {
  western();
  await page.setViewportSize({ width: 1280, height: 720 });
  await open(page, '?t=33432');
  const rows = page.getByTestId('target-rows');
  await expect(rows.locator('[data-target]')).toHaveCount(24);
  const room = await rows.evaluate(node => [node.scrollHeight, node.clientHeight]);
  expect(room[0]).toBeLessThanOrEqual((room[1] ?? 0) + 1);
  const box = await page.getByTestId('timeline').boundingBox();
  const end = await rows.boundingBox();
  if (!box || !end) throw new Error('no timeline');
  expect(box.y + box.height - (end.y + end.height) - 3 * 27).toBeGreaterThanOrEqual(9 * 15);
});

/** Parts of the header and panels that lie on each other or leave the screen. */
function overlaps(page: Page): Promise<string[]> {
  return page.evaluate(() => {
    const found: string[] = [];
    if (document.documentElement.scrollWidth > window.innerWidth) found.push('the page scrolls sideways');
    const parts = [...document.querySelectorAll('header h1, header span, header button')].filter(
      node =>
        node.closest('header')?.querySelector('h1') &&
        node.children.length === 0 &&
        node.getClientRects().length > 0,
    );
    const boxes = parts.map(node => ({ text: node.textContent, box: node.getBoundingClientRect() }));
    for (const [index, one] of boxes.entries()) {
      if (one.box.right > window.innerWidth + 0.5 || one.box.left < -0.5)
        found.push(`${one.text} leaves the screen`);
      for (const two of boxes.slice(index + 1)) {
        const across = Math.min(one.box.right, two.box.right) - Math.max(one.box.left, two.box.left);
        const down = Math.min(one.box.bottom, two.box.bottom) - Math.max(one.box.top, two.box.top);
        if (across > 0.5 && down > 0.5) found.push(`${one.text} lies on ${two.text}`);
      }
    }
    const panels = [...document.querySelectorAll('main section')].filter(
      node => !node.parentElement?.closest('section'),
    );
    for (const [index, one] of panels.entries()) {
      const [a, name] = [one.getBoundingClientRect(), one.getAttribute('aria-label')];
      for (const two of panels.slice(index + 1)) {
        const b = two.getBoundingClientRect();
        const across = Math.min(a.right, b.right) - Math.max(a.left, b.left);
        const down = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
        if (across > 0.5 && down > 0.5) found.push(`${name} lies on ${two.getAttribute('aria-label')}`);
      }
    }
    return found;
  });
}

for (const theme of ['dark', 'light']) {
  test(`no panels and no parts of the header overlap at any size, ${theme}`, async ({ page }) => {
    await open(page, `?t=40000&theme=${theme}`);
    for (const [width, height] of SCREENS) {
      await page.setViewportSize({ width, height });
      expect(await overlaps(page), `${width}x${height}`).toEqual([]);
    }
  });
}

for (const theme of ['dark', 'light']) {
  test(`axe finds nothing at the page's states, ${theme}`, async ({ page }) => {
    await open(page, `?t=40000&theme=${theme}`);
    const check = (state: string) => expectNoFaults(page, state);
    await check('nothing selected');
    await page.locator('[data-task]').nth(1).click();
    await expect(page.getByTestId('why')).toBeVisible();
    await check('a task selected');
    await page.getByTestId('tab-report').click();
    await check('report before the end');
    await page.keyboard.press('End');
    await expect(page.getByTestId('status')).toHaveText('ended');
    await check('report at the end');
    await page.keyboard.press('?');
    await expect(page.getByRole('dialog')).toBeVisible();
    await check('help');
  });
}

// Other missions fill the panels otherwise: longer lines of source, no targets, another vehicle.
for (const mission of ['structure-watch', 'pipeline-inspection', 'day-and-night', 'first-picture']) {
  test(`axe finds nothing on ${mission}`, async ({ page }) => {
    const record = join(dirname(process.env.APEX_RECORD ?? ''), `${mission}.apex`);
    test.skip(!existsSync(record), `needs ${record}: make flights`);
    const other = await startServer(record);
    try {
      await page.goto(other.url);
      await expect(page.locator('[data-task]').first()).toBeVisible();
      await page.keyboard.press('End');
      await expect(page.getByTestId('status')).toHaveText('ended');
      await expectNoFaults(page, 'the end of the flight');
      for (const index of [0, 1, 2]) {
        await page.locator('[data-task]').nth(index).click();
        await expect(page.getByTestId('why')).toBeVisible();
        await expectNoFaults(page, `task ${index + 1} of the agenda selected`);
      }
    } finally {
      other.stop();
    }
  });
}
