/** Sherpa on a real flight record in a real browser; its display is compared with the server's answers. */

import { expect, type Page, test } from '@playwright/test';
import type { Mission, Targets, Task, TaskExplanation, Tasks, Track } from '../src/record/types';
import { COLOURS, stateColour } from '../src/theme/colours';
import { countColours } from './pixels';
import { type Server, startServer } from './server';

/** The width of the timeline's column of names. */
const NAMES_PX = 168;
/** The height of the time axis, below the rail of failures and faults. */
const AXIS_Y_PX = 26;

let server: Server;
let mission: Mission;
let faults: string[];

test.beforeAll(async () => {
  server = await startServer();
  mission = await ask('mission');
});
test.afterAll(() => server?.stop());

test.beforeEach(async ({ page }) => {
  faults = [];
  page.on('pageerror', error => faults.push(error.message));
  page.on('console', message => {
    if (message.type() === 'error') faults.push(message.text());
  });
  await page.goto(server.url);
  await expect(page.locator('[data-task]').first()).toBeVisible();
});
test.afterEach(() => expect(faults, 'errors in the page').toEqual([]));

async function ask<T>(what: string): Promise<T> {
  const response = await fetch(`${server.url}/api/${what}`);
  expect(response.ok, `${what}: ${response.status}`).toBe(true);
  return response.json() as Promise<T>;
}

/** Moves the cursor by a click into the timeline's axis. */
async function clickTime(page: Page, share: number): Promise<void> {
  const timeline = page.getByTestId('timeline');
  const width = await timeline.evaluate(node => node.clientWidth);
  // The click waits until the axis is where it stays.
  await timeline.click({ position: { x: NAMES_PX + (width - NAMES_PX) * share, y: AXIS_Y_PX } });
}

test('the header names the mission, its status and its score', async ({ page }) => {
  await expect(page.getByTestId('title')).toHaveText(mission.mission ?? mission.record);
  await expect(page.getByTestId('status')).toHaveText('recorded');
  await page.keyboard.press('End');
  await expect(page.getByTestId('status')).toHaveText('ended');
  await expect(page.getByTestId('score')).toHaveCount(mission.score === null ? 0 : 1);
});

test('the map shows ground, flown track and targets in their states', async ({ page }) => {
  const track = await ask<Track>('track');
  const targets = (await ask<Targets>('targets')).targets;
  const flies = new Set(track.latitude_deg).size > 2;
  const states = [...new Set(targets.flatMap(target => target.state ?? []))];
  const map = page.getByTestId('map');

  await page.keyboard.press('Home');
  await expect(page.getByTestId('time')).toContainText(/T\+/);
  const before = await countColours(page, map, [COLOURS.flown]);
  await page.keyboard.press('End');
  const wanted = [COLOURS.sea, COLOURS.land, COLOURS.flown, ...states.map(stateColour)];
  await expect
    .poll(
      async () => {
        const seen = await countColours(page, map, wanted);
        const ground = (seen[COLOURS.sea] ?? 0) + (seen[COLOURS.land] ?? 0);
        return {
          ground: ground > 50_000,
          flown: !flies || (seen[COLOURS.flown] ?? 0) > (before[COLOURS.flown] ?? 0) + 20,
          targets: states.every(state => (seen[stateColour(state)] ?? 0) > 5),
        };
      },
      { timeout: 30_000 },
    )
    .toEqual({ ground: true, flown: true, targets: true });
  for (const state of states) {
    const count = targets.filter(target => target.state === state).length;
    await expect(page.getByTestId(`legend-${state}`)).toHaveText(String(count));
  }
});

test('a task in the tree tells why', async ({ page }) => {
  await page.keyboard.press('End');
  const { tasks } = await ask<Tasks>(`tasks?at=${mission.end_ns}`);
  const root = tasks.find(task => task.parent === null) as Task;
  const child = tasks.find(task => task.parent === root.id) ?? root;
  const row = page.locator(`[data-task="${child.id}"]`);
  await expect(row).toHaveAttribute('data-state', child.state);
  await row.click();

  const why = await ask<TaskExplanation>(`why?task=${child.id}&at=${mission.end_ns}&explain=false`);
  const panel = page.getByTestId('why');
  await expect(panel).toContainText(why.task.goal);
  await expect(panel).toContainText(why.now);
  expect(why.explanation.history.length).toBeGreaterThan(0);
  await expect(panel.getByTestId('cause')).toHaveCount(why.explanation.history.length);
  if (why.task.place && !why.task.place.startsWith('<'))
    await expect(panel.getByTestId('source')).toBeVisible();
});

test('moving the time cursor changes the states', async ({ page }) => {
  const first = await ask<Tasks>(`tasks?at=${mission.from_ns}`);
  const last = await ask<Tasks>(`tasks?at=${mission.end_ns}`);
  const root = last.tasks.find(task => task.parent === null) as Task;
  const row = page.locator(`[data-task="${root.id}"]`);
  const time = page.getByTestId('time');

  await page.keyboard.press('Home');
  await expect(row).toHaveAttribute('data-state', first.tasks.find(task => task.id === root.id)?.state ?? '');
  const start = await time.textContent();
  await page.keyboard.press('End');
  await expect(row).toHaveAttribute('data-state', root.state);
  await expect(time).not.toHaveText(start ?? '');

  await clickTime(page, 0.5);
  const middle = (await time.textContent()) ?? '';
  expect(middle).not.toBe(start);
  await page.keyboard.press('ArrowRight');
  await expect(time).not.toHaveText(middle);
  await page.keyboard.press('ArrowLeft');
  await expect(time).toHaveText(middle);
});

test('the record plays', async ({ page }) => {
  const time = page.getByTestId('time');
  await page.keyboard.press('Home');
  const start = await time.textContent();
  await page.getByTestId('play').click();
  await expect(time).not.toHaveText(start ?? '');
  await page.keyboard.press('Space');
});

test('the filter finds tasks, and ended ones can be hidden', async ({ page }) => {
  await page.keyboard.press('End');
  const { tasks } = await ask<Tasks>(`tasks?at=${mission.end_ns}`);
  const some = tasks.at(-1) as Task;
  await page.keyboard.press('/');
  await page.keyboard.type(`T${some.id}`);
  await expect(page.locator(`[data-task="${some.id}"]`)).toBeVisible();
  const above = new Set<number>();
  for (let task: Task | undefined = some; task; task = tasks.find(other => other.id === task?.parent))
    above.add(task.id);
  await expect(page.locator('[data-task]')).toHaveCount(above.size);

  await page.keyboard.press('Escape');
  await page.locator('#task-filter').fill('');
  await page.getByTestId('show-ended').click();
  const open = await ask<Tasks>(`tasks?at=${mission.end_ns}&ended=false`);
  const ended = open.tasks.filter(task => task.state === 'terminated').length;
  await expect(page.locator('[data-task][data-state="terminated"]')).toHaveCount(ended);
});

test('help, log and report open', async ({ page }) => {
  await page.keyboard.press('End');
  await page.keyboard.press('?');
  await expect(page.getByRole('dialog')).toBeVisible();
  await page.keyboard.press('Escape');
  await expect(page.getByRole('dialog')).toBeHidden();
  await page.getByTestId('tab-log').click();
  await expect(page.getByTestId('log').locator('tr').nth(1)).toBeVisible();
});
