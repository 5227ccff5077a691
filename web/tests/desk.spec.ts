/** The desk: panels in slots, and panels that show the state at an instant: objects, program, network, monitors, trace, now. */

import { execFileSync } from 'node:child_process';
import { existsSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { expect, type Page, test } from '@playwright/test';
import type {
  Events,
  Holdings,
  Mission,
  Monitors,
  PlanInForce,
  Plans,
  ProgramContents,
  Tasks,
} from '../src/record/types';
import { expectNoFaults } from './axe';
import { apexProgram, type Server, startServer } from './server';

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

/** Opens the page at an instant in the middle of the flight, in whole seconds. */
async function open(page: Page, address = ''): Promise<number> {
  const seconds = Math.round(mission.end_ns / 2e9);
  await page.goto(`${server.url}/?t=${seconds}${address}`);
  await expect(page.getByTestId('now')).not.toContainText('reading');
  return seconds;
}

/** The executive's recorded decisions up to an instant, and samples of a state variable if one is given. */
function trace(
  seconds: number,
  kinds: string,
  variable?: string,
): { t: number; task?: string; [key: string]: unknown }[] {
  const out = execFileSync(
    apexProgram(),
    [
      ...['trace', process.env.APEX_RECORD ?? '', '--json', '--type', kinds, '--to', `${seconds}s`],
      ...(variable ? ['--object', variable] : []),
    ],
    { maxBuffer: 1 << 29 },
  );
  return out
    .toString()
    .split('\n')
    .filter(Boolean)
    .map(line => JSON.parse(line));
}

test('the page fills the screen and does not scroll as a whole', async ({ page }) => {
  for (const [width, height] of [
    [1280, 720],
    [1920, 1080],
  ] as const) {
    await page.setViewportSize({ width, height });
    await open(page);
    const size = await page.evaluate(() => [
      document.documentElement.scrollHeight,
      document.documentElement.scrollWidth,
    ]);
    expect(size).toEqual([height, width]);
    for (const name of ['map', 'slot-left', 'timeline', 'slot-right'])
      await expect(page.getByTestId(name)).toBeInViewport({ ratio: 0.99 });
  }
});

test('the now line names the holder of the flight path, its cause, and the next visit of the plan', async ({
  page,
}) => {
  const seconds = await open(page);
  const at = seconds * 1e9;
  const { resources } = await ask<Holdings>(`holdings?from=${at}&to=${at}&at=${at}`);
  const held = resources.find(row => row.resource === 'flight-path') ?? resources[0];
  const holder = held?.holdings.findLast(one => one.open || one.to_ns > at);
  await page.getByTestId('now-task').click();
  if (holder) await expect(page).toHaveURL(new RegExp(`sel=task:${holder.task}`));
  const plan = await ask<PlanInForce | null>(`plan?at=${at}`);
  if (plan?.visits.some(visit => visit.begin_ns > at))
    await expect(page.getByTestId('now')).toContainText('next');
  await page.keyboard.press('End');
  await expect(page.getByTestId('now')).toContainText('ended');
});

test('objects: agents, procedures, resources with holders, monitors, variables', async ({ page }) => {
  const seconds = await open(page, '&left=objects');
  const tree = page.getByTestId('objects');
  await expect(tree.getByRole('treeitem', { level: 1 })).toHaveCount(5);
  await expect(tree).toContainText(mission.agent ?? '?');
  const at = seconds * 1e9;
  const { resources } = await ask<Holdings>(`holdings?from=${at}&to=${at}&at=${at}`);
  for (const { resource, holdings } of resources) {
    const row = tree.locator(`[data-row="resource ${resource}"]`);
    await expect(row).toHaveCount(1);
    const isHeld = holdings.some(one => one.from_ns <= at && (one.open || one.to_ns > at));
    await expect(row.locator('.glyph')).toHaveText(isHeld ? '●' : '○');
  }
  // With keys: down to the procedures, open them, open a file, show a procedure in the program.
  await tree.getByRole('treeitem').first().focus();
  await page.keyboard.press('End');
  await expect(tree.getByRole('treeitem').last()).toBeFocused();
  await tree.locator('[data-row="procedures"]').focus();
  await page.keyboard.press('ArrowRight');
  await expect(tree.locator('[data-row="procedures"]')).toHaveAttribute('aria-expanded', 'true');
  await expectNoFaults(page, 'objects');
  await tree.locator('[data-row^="file "]').first().press('ArrowRight');
  await tree.locator('[data-row^="procedure "]').first().press('Enter');
  await expect(page.getByTestId('program-text').locator('.here')).toHaveCount(1);
});

test('the program marks exactly the lines whose steps are executed at the instant', async ({ page }) => {
  const seconds = await open(page, '&left=program');
  const { tasks } = await ask<Tasks>(`tasks?at=${seconds * 1e9}&limit=20000`);
  const { files } = await ask<ProgramContents>('program');
  expect(files.length).toBeGreaterThan(0);
  const busy = tasks.filter(task => task.state === 'ongoing' && task.place);
  const fileOf = (place: string) => place.replace(/:\d+:\d+$/, '');
  const file = files.find(one => busy.some(task => fileOf(task.place ?? '') === one.name));
  if (!file) throw new Error('no file of the program is executed at this instant');
  await page.getByTestId('program-file').selectOption(file.name);
  const text = page.getByTestId('program-text');
  await expect(text.locator('[data-line]')).toHaveCount(file.lines);
  const lines = new Set(
    busy.filter(task => fileOf(task.place ?? '') === file.name).map(task => task.place?.split(':').at(-2)),
  );
  await expect(text.locator('.executing')).toHaveCount(lines.size);
  await text.locator('.executing button').first().click();
  await expect(page).toHaveURL(/sel=task:\d+/);
  // The variables of the selected task equal those of the restored agent.
  const id = new URL(page.url()).searchParams.get('sel')?.split(':')[1];
  const { bindings } = await ask<Monitors>(`monitors?at=${seconds * 1e9}&task=${id}`);
  if (bindings.length > 0)
    await expect(page.getByTestId('bindings').locator('dt')).toHaveCount(bindings.length);
  await page.getByTestId('find-procedure').fill('observe');
  await expect(page.getByTestId('procedures').getByRole('listitem').first()).toBeVisible();
  await expectNoFaults(page, 'program with a search');
});

test('monitors show value, limit and since when of the samples of the record', async ({ page }) => {
  const seconds = await open(page, '&tab=monitors');
  const monitors = await ask<Monitors>(`monitors?at=${seconds * 1e9}`);
  expect(monitors.monitors.length).toBeGreaterThan(0);
  const panel = page.getByTestId('monitors');
  await expect(page.getByTestId('monitor-count')).toContainText(
    `${monitors.monitors.length} watched clauses`,
  );
  type Part = Monitors['monitors'][number]['condition'];
  const leaves = (part: Part): Part[] => (part.parts.length === 0 ? [part] : part.parts.flatMap(leaves));
  const measured = monitors.monitors
    .flatMap(one => leaves(one.condition))
    .filter(part => part.value !== null);
  test.skip(measured.length === 0, 'no condition watches a measured value at this instant');
  // A second source: the newest sample that `apex trace` prints of that variable.
  const [leaf] = measured;
  const name = (leaf?.variable ?? '').replace(/^\(|\)$/g, '');
  const samples = trace(seconds, 'measurement', name).filter(line => JSON.stringify(line).includes(name));
  const newest = JSON.stringify(samples.at(-1) ?? {});
  const number = Number.parseFloat(leaf?.value ?? '');
  if (!Number.isNaN(number)) expect(newest).toContain(String(number).slice(0, 5));
  await expect(panel.locator('.value').first()).toBeVisible();
  await expectNoFaults(page, 'monitors');
  await panel
    .getByRole('treeitem')
    .filter({ has: page.locator('.value') })
    .first()
    .click();
  await expect(page.getByTestId('signal').first()).toBeVisible();
});

test('the network of a procedure and of the plan', async ({ page }) => {
  const seconds = await open(page, '&left=network&sel=task:0');
  const { tasks } = await ask<Tasks>(`tasks?at=${seconds * 1e9}&limit=20000`);
  const { procedures } = await ask<ProgramContents>('program');
  const root = tasks.find(task => task.parent === null);
  const row = procedures.find(one => `procedure ${one.place}` === root?.method);
  const network = page.getByTestId('network');
  await expect(network.locator('[data-node]')).toHaveCount(row?.steps.length ?? -1);
  // Ongoing steps have the full circle, like their tasks in the record.
  for (const step of row?.steps ?? []) {
    const task = tasks.findLast(one => one.parent === root?.id && one.place === step.place);
    if (task?.state === 'ongoing')
      await expect(network.locator(`[data-node="${step.tag}"] .words`)).toContainText('●');
  }
  await expectNoFaults(page, 'network');
  const plan = await ask<PlanInForce | null>(`plan?at=${seconds * 1e9}`);
  if (plan) {
    await page.getByTestId('network-plan').click();
    await expect(network.locator('[data-node]')).toHaveCount(plan.visits.length);
  }
  const download = page.waitForEvent('download');
  await page.getByTestId('export-network').click();
  const file = await (await download).path();
  const svg = execFileSync('head', ['-c', '2000', file]).toString();
  expect(svg).toContain('<svg');
  expect(svg).toContain('fill="rgb(');
  expect(svg).not.toContain('style=');
});

test('filters of the trace are those of apex trace, and are kept under a name', async ({ page }) => {
  const seconds = await open(page, '&tab=log');
  await page.getByLabel('Kind of events').selectOption('transition');
  await page.getByTestId('trace-task').fill('T0');
  const lines = page.getByTestId('log').locator('tr');
  const own = trace(seconds, 'transition').filter(line => line.task === 'T0' || line.task === 'T0'.slice(1));
  if (own.length > 0) await expect(lines).toHaveCount(own.length);
  await page.getByTestId('filter-name').fill('root');
  await page.getByTestId('save-filter').click();
  await page.getByTestId('trace-task').fill('');
  await page.reload();
  await page.getByTestId('saved-filter').click();
  await expect(page.getByTestId('trace-task')).toHaveValue('T0');
  await expectNoFaults(page, 'trace with a saved filter');
  await page.getByLabel('Forget the filter root').click();
  await expect(page.getByTestId('saved-filter')).toHaveCount(0);
});

test('panels move between the slots, columns change their width, and address and browser keep both', async ({
  page,
}) => {
  await open(page, '&tab=signals');
  await page.getByTestId('layout-right').click();
  await page.getByTestId('move-right').click();
  await expect(page.getByTestId('slot-left').getByTestId('tab-signals')).toHaveAttribute(
    'aria-selected',
    'true',
  );
  const edge = page.getByRole('separator', { name: 'Width of the left column' });
  await edge.focus();
  const before = Number(await edge.getAttribute('aria-valuenow'));
  await page.keyboard.press('ArrowRight');
  await expect(edge).toHaveAttribute('aria-valuenow', String(before + 16));
  await expect(page).toHaveURL(/layout=/);
  const url = page.url();
  await page.goto(server.url);
  await expect(page.getByTestId('slot-left').getByTestId('tab-signals')).toBeVisible();
  await page.getByTestId('layout-left').click();
  await page.getByRole('button', { name: 'Usual layout' }).click();
  await expect(page.getByTestId('slot-right').getByTestId('tab-signals')).toBeVisible();
  await page.goto(url);
  await expect(page.getByTestId('slot-left').getByTestId('tab-signals')).toBeVisible();
  await page.goto(`${server.url}/?layout=sofa_bed`);
  await expect(page.getByRole('alert')).toContainText('The address has layout=sofa_bed');
});

test('alarms count repeats, are known only from their time on, and none can be acknowledged on a record', async ({
  page,
}) => {
  await page.goto(`${server.url}/?t=0&tab=alarms`);
  await expect(page.getByTestId('alarm-count')).toContainText('0 alarms');
  await page.keyboard.press('End');
  await expect(page.getByTestId('alarms')).toBeVisible();
  await expect(page.getByTestId('acknowledge')).toHaveCount(0);
  await expectNoFaults(page, 'alarms');
});

test('every panel and each half of the screen sizes are free of faults, in both themes', async ({ page }) => {
  test.setTimeout(240_000);
  for (const theme of ['dark', 'light']) {
    await open(page, `&theme=${theme}&left=draft&tab=why`);
    for (const panel of ['draft', 'why', 'plans', 'whatif', 'compare', 'log']) {
      await page.getByTestId(`tab-${panel}`).click();
      await expect(page.locator(`[data-panel="${panel}"]`)).toBeVisible();
      await expectNoFaults(page, `${panel}, ${theme}`);
    }
  }
});

test('the first load is small and asks no other server', async ({ page }) => {
  let bytes = 0;
  const foreign: string[] = [];
  page.on('response', async response => {
    const url = new URL(response.url());
    if (!server.url.includes(url.host) && url.protocol.startsWith('http')) foreign.push(response.url());
    const sizes = await response
      .request()
      .sizes()
      .catch(() => null);
    if (!url.pathname.startsWith('/api/')) bytes += sizes?.responseBodySize ?? 0;
  });
  await page.goto(server.url);
  await page.waitForLoadState('networkidle');
  expect(foreign).toEqual([]);
  expect(bytes, 'bytes of scripts, styles, fonts and the base map').toBeLessThan(1_500_000);
});

test('two agents of one record: each has its own tasks, and both are on one time axis', async ({ page }) => {
  const record = join(dirname(process.env.APEX_RECORD ?? ''), 'two-crew.apex');
  const own = existsSync(record) ? record : null;
  const path = own ?? join(test.info().outputPath(), 'two-crew.apex');
  if (!own)
    execFileSync(
      apexProgram(),
      ['fly', join(import.meta.dirname, '../../missions/two-crew'), '--record', path, '--no-progress'],
      { stdio: 'ignore' },
    );
  const crew = await startServer(path);
  try {
    await page.goto(`${crew.url}/?t=60`);
    const records = page.getByTestId('records');
    await expect(records.locator('option')).toHaveCount(2);
    const first = await page.getByTestId('agenda').textContent();
    await records.selectOption({ index: 1 });
    await expect(page).toHaveURL(/rec=1/);
    await expect(page).toHaveURL(/t=60/);
    await expect(page.locator('[data-task]').first()).toBeVisible();
    expect(await page.getByTestId('agenda').textContent()).not.toBe(first);
    const answer = await fetch(`${crew.url}/api/records/1/mission`);
    const { agent } = (await answer.json()) as Mission;
    expect(
      execFileSync(apexProgram(), ['trace', path, '--agent', agent ?? '', '--json'], {
        maxBuffer: 1 << 28,
      }).toString(),
    ).toContain('transition');
    await page.getByTestId('tab-compare').click();
    await page.getByTestId('compare-with').selectOption('0');
    await expect(page.getByTestId('compare-rows')).toBeVisible();
    await expect(page).toHaveURL(/vs=0/);
    await expectNoFaults(page, 'two agents');
  } finally {
    crew.stop();
  }
});

test('an event of the log is selected in the address, Back undoes it, and its link shows it again', async ({
  page,
}) => {
  const seconds = await open(page, '&tab=log');
  const [later, earlier] = [page.locator('[data-event]').nth(2), page.locator('[data-event]').nth(20)];
  const number = await later.getAttribute('data-event');
  await later.locator('button').first().click();
  await expect(page).toHaveURL(new RegExp(`sel=event:${number}`));
  const first = page.locator(`[data-event="${number}"]`);
  await expect(first).toHaveAttribute('aria-current', 'true');
  const url = page.url();
  const second = await earlier.getAttribute('data-event');
  await earlier.locator('button').first().click();
  await expect(page).toHaveURL(new RegExp(`sel=event:${second}`));
  await page.goBack();
  await expect(page).toHaveURL(url);
  await expect(first).toHaveAttribute('aria-current', 'true');
  const [time, words] = [await page.getByTestId('time').textContent(), await first.innerText()];

  // Without an instant the link leads to that of the event, as the record has it.
  await page.goto(`${server.url}/?sel=event:${number}`);
  await expect(page.getByTestId('time')).toHaveText(time ?? '');
  await expect(first).toHaveAttribute('aria-current', 'true');
  await expect(first).toBeInViewport();
  expect(await first.innerText()).toBe(words);
  const { events } = await ask<Events>(`events?before=${Number(number) + 1}&limit=1`);
  const event = events[0];
  if (!event) throw new Error('the event is not in the record');
  const recorded = trace(seconds, event.kind).filter(line => Math.round(line.t * 1e9) === event.t_ns);
  expect(recorded.length).toBeGreaterThan(0);

  // An instant before the event: the page reports it, and shows nothing of the event.
  await page.goto(`${server.url}/?t=0&sel=event:${number}`);
  await expect(page.getByTestId('selected-event')).toContainText(
    `Event ${number} comes later than this time.`,
  );
  await page.goto(`${server.url}/?sel=event:999999999`);
  await expect(page.getByRole('alert')).toContainText(
    'sel=event:999999999; the record has no event 999999999',
  );
  await expect(page.getByTestId('selected-event')).toHaveText('The record has no event 999999999.');
  await expectNoFaults(page, 'a selected event that does not exist');
});

test('a plan is selected in the address, Back undoes it, and its link shows it again', async ({ page }) => {
  const { plans } = await ask<Plans>(`plans?at=${mission.end_ns}`);
  const [plan] = plans;
  if (!plan) throw new Error('the flight has no plan');
  await page.goto(`${server.url}/?t=${Math.round(mission.end_ns / 1e9)}&tab=plans`);
  const shown = page.locator(`[data-plan="${plan.number}"]`);
  await shown.getByRole('button', { name: `Plan ${plan.number}`, exact: true }).click();
  await expect(page).toHaveURL(new RegExp(`sel=plan:${plan.number}`));
  await expect(shown).toHaveAttribute('aria-current', 'true');
  await page.goBack();
  await expect(page).not.toHaveURL(/sel=/);
  await expect(shown).toHaveAttribute('aria-current', 'false');

  // The link alone opens the panel and the instant of the plan.
  await page.goto(`${server.url}/?sel=plan:${plan.number}`);
  await expect(shown).toHaveAttribute('aria-current', 'true');
  await expect(shown).toBeInViewport();
  const adopted = trace(Math.ceil(plan.adopted_ns / 1e9), 'plan');
  expect(adopted.some(line => Math.round(line.t * 1e9) === plan.adopted_ns)).toBe(true);

  await page.goto(`${server.url}/?t=0&sel=plan:999`);
  await expect(page.getByRole('alert')).toContainText('sel=plan:999; the flight has no plan 999');
  await expect(page.getByTestId('missing-plan')).toHaveText('No plan 999 was adopted by this time.');
  await expectNoFaults(page, 'a selected plan that does not exist');
});
