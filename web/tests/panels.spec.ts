/** Rows of the timeline, layers of the map, plans, exports and the printable report, against the record. */

import { execFileSync } from 'node:child_process';
import { readFileSync } from 'node:fs';
import { expect, type Page, test } from '@playwright/test';
import { parquetReadObjects } from 'hyparquet';
import type {
  Footprints,
  Holdings,
  Mission,
  MissionFacts,
  PlanInForce,
  Plans,
  Targets,
  Tasks,
} from '../src/record/types';
import { COLOURS, LIGHT } from '../src/theme/colours';
import { expectNoFaults } from './axe';
import { countColours, rowsWithout } from './pixels';
import { tilesOfOneArea } from './pmtiles';
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

async function open(page: Page, address: string): Promise<void> {
  await page.goto(`${server.url}/${address}`);
  await expect(page.locator('[data-task]').first()).toBeVisible();
}

/** Share of a thin slanted line that has its pure colour on the screen; the rest is blended or covered by other marks. */
const USER_SHARE = 0.15;

/** Returns the length of a line on the map in pixels; the map is fitted to the places of the flight (FlightMap.svelte). */
async function lengthOnMap(page: Page, [from, to]: number[][]): Promise<number> {
  const { targets } = await ask<Targets>(`targets?at=${mission.end_ns}`);
  const north = (latitude = 0) =>
    (Math.log(Math.tan(Math.PI / 4 + (latitude * Math.PI) / 360)) * 180) / Math.PI;
  const x = targets.map(target => target.longitude_deg ?? 0);
  const y = targets.map(target => north(target.latitude_deg ?? 0));
  const spread = (values: number[]) => Math.max(...values) - Math.min(...values);
  const box = (await page.getByTestId('map').boundingBox()) ?? { width: 0, height: 0 };
  const scale = Math.min((box.width - 120) / spread(x), (box.height - 74) / spread(y));
  const [east = 0, up = 0] = [(to?.[0] ?? 0) - (from?.[0] ?? 0), north(to?.[1]) - north(from?.[1])];
  return Math.hypot(east, up) * scale;
}

/** Clicks a button that saves a file, and returns the bytes of the file. */
async function saved(page: Page, button: string): Promise<Buffer> {
  const [download] = await Promise.all([page.waitForEvent('download'), page.getByTestId(button).click()]);
  return readFileSync(await download.path());
}

/** Expects the browser to parse the text as SVG without errors, and without inline styles. */
async function expectSvg(page: Page, text: string): Promise<void> {
  const fault = await page.evaluate(
    svg =>
      new DOMParser().parseFromString(svg, 'image/svg+xml').querySelector('parsererror')?.textContent ?? null,
    text,
  );
  expect(fault).toBeNull();
  expect(text).not.toContain('style=');
}

const western = () => test.skip(mission.mission !== 'Western States Fire Mission', 'needs western-states');

test('every target has a row with the times of all plans, and none before it is known', async ({ page }) => {
  western();
  // Before the last planned visit begins.
  const at = 70_000;
  await open(page, `?t=${at}&rows=targets`);
  const { targets } = await ask<Targets>(`targets?at=${at}000000000`);
  await expect(page.locator('[data-target]')).toHaveCount(targets.length);
  const { plans } = await ask<Plans>(`plans?at=${at}000000000`);
  const planned = plans.at(-1)?.visits.at(-1);
  if (!planned) throw new Error('the plan has no visits');
  const row = page.locator(`[data-target="${planned.target}"]`);
  const circle = row.locator('circle.planned');
  await expect(circle).toHaveCount(1);
  // All views of the column have the same time scale (P4).
  const box = await page.getByTestId('timeline').boundingBox();
  const x = (await circle.boundingBox()) ?? { x: 0, width: 0 };
  const room = (box?.width ?? 0) - 168;
  const { duration_ns } = await ask<MissionFacts>('facts');
  const expected = (box?.x ?? 0) + 168 + (planned.begin_ns / duration_ns) * room;
  expect(Math.abs(x.x + x.width / 2 - expected)).toBeLessThan(1.5);
  // The trace of the executive is the second source of the adopted plans.
  const trace = execFileSync(
    apexProgram(),
    ['trace', process.env.APEX_RECORD ?? '', '--json', '--type', 'plan'],
    { maxBuffer: 1 << 28 },
  );
  const adopted = trace
    .toString()
    .trim()
    .split('\n')
    .map(line => JSON.parse(line))
    .filter(event => event.t <= at);
  expect(plans.length).toBe(adopted.length);
  await expectNoFaults(page, 'rows of targets');
  await open(page, '?t=0&rows=targets');
  await expect(page.locator('[data-target]')).toHaveCount(22);
  await expect(page.getByTestId('target-rows').locator('circle.planned')).toHaveCount(0);
});

test('rows of resources name the holder of the instant', async ({ page }) => {
  western();
  await open(page, '?t=40000&rows=resources');
  const { resources } = await ask<Holdings>('holdings?at=40000000000000');
  const rows = page.getByTestId('resource-rows');
  await expect(rows.getByRole('row')).toHaveCount(resources.length);
  const path = resources.find(row => row.resource === 'flight-path');
  // A child holds its parent's resource: the last open holding belongs to the task that executes.
  const holder = path?.holdings.findLast(one => one.open);
  await expect(rows.getByRole('row').first()).toContainText('flight-path');
  if (holder)
    await expect(rows.locator('[role="gridcell"]').first()).toHaveAttribute(
      'title',
      new RegExp(`T${holder.task} `),
    );
  await expectNoFaults(page, 'rows of resources');
  await rows.locator('.bar').last().click();
  await expect(page).toHaveURL(/sel=task:\d+/);
});

test('the map shows ground seen, wind, reach and the replaced plan, and only what was known', async ({
  page,
}) => {
  western();
  const seen = async (at: number) => (await ask<Footprints>(`footprints?at=${at}000000000`)).swaths.length;
  expect(await seen(1)).toBe(0);
  expect(await seen(20_000)).toBeGreaterThan(0);
  const at = 75_000;
  // The drawing has each patch and each way as a path, the picture on the screen also letters whose edges come near these colours.
  const drawn = async () => {
    const drawing = (await saved(page, 'export-map-svg')).toString();
    const paths = (mark: string) => drawing.split('<path ').filter(path => path.includes(mark)).length;
    return { seen: paths(`fill="${COLOURS.seen}"`), ghost: paths(`stroke="${COLOURS.ghost}"`) };
  };
  const pixels = async () => (await countColours(page, map, [COLOURS.seen]))[COLOURS.seen] ?? 0;
  await open(page, '?t=1');
  const map = page.getByTestId('map');
  await expect(page.getByTestId('wind')).toContainText(/wind from \d{3}° at \d+ kt, measured/);
  expect(await drawn()).toEqual({ seen: 0, ghost: 0 });
  const before = await pixels();
  await open(page, `?t=${at}`);
  await expect.poll(pixels).toBeGreaterThan(before + 20);
  const { plans } = await ask<Plans>(`plans?at=${at}000000000`);
  expect(plans.slice(0, -2).every((plan: PlanInForce) => plan.route.length === 0)).toBe(true);
  expect(plans.at(-2)?.route.length).toBeGreaterThan(10);
  const later = await drawn();
  expect(later.seen).toBeGreaterThan(await seen(20_000));
  expect(later.ghost).toBe(1);
  await expectNoFaults(page, 'map with all layers');
});

test('the ground of the map is drawn down to its lower edge, and the legend hides none of it', async ({
  page,
}) => {
  western();
  // Lines of latitude hide single rows of the sea. In the light theme the sea has another colour than the panel; the Pacific is west of the flight.
  await open(page, '?t=33432&theme=light');
  await page.getByTestId('now-task').click();
  await expect(page.getByTestId('legend-observed')).toBeVisible();
  const ground = page.getByTestId('map').locator('.maplibregl-map');
  await expect.poll(() => rowsWithout(page, ground, LIGHT.sea)).toBeLessThan(3);
  const legend = await page.getByLabel('Targets by state').boundingBox();
  const box = await ground.boundingBox();
  expect((legend?.y ?? 0) + (legend?.height ?? 0)).toBeLessThanOrEqual(box?.y ?? 0);
});

test('a layer of the user is drawn, never sent, and a wrong file is explained', async ({ page }) => {
  await open(page, '?t=100');
  const sent: string[] = [];
  page.on('request', request => {
    if (request.method() !== 'GET') sent.push(request.url());
  });
  const map = page.getByTestId('map');
  const file = (name: string, text: string) => ({
    name,
    mimeType: 'application/json',
    buffer: Buffer.from(text),
  });
  const line = {
    type: 'LineString',
    coordinates: [
      [-122, 36],
      [-112, 47],
    ],
  };
  await page.getByTestId('layer-file').setInputFiles(file('roads.geojson', JSON.stringify(line)));
  await expect(page.getByTestId('user-layer')).toContainText('roads.geojson');
  if (mission.mission === 'Western States Fire Mission')
    await expect
      .poll(async () => (await countColours(page, map, [COLOURS.user]))[COLOURS.user] ?? 0)
      .toBeGreaterThan(USER_SHARE * (await lengthOnMap(page, line.coordinates)));
  await page.getByTestId('layer-file').setInputFiles(file('bad.json', '{"type": "Topology"}'));
  await expect(page.getByTestId('layer-fault')).toContainText('bad.json is not GeoJSON');
  await expectNoFaults(page, 'a layer and a wrong file');
  expect(sent).toEqual([]);
  await page.getByTestId('user-layer').click();
  await expect(page.getByTestId('user-layer')).toHaveCount(0);
});

test('tiles of the user are drawn from a file that stays in the browser', async ({ page }) => {
  await open(page, '?t=100');
  const sent: string[] = [];
  page.on('request', request => {
    if (!request.url().startsWith(server.url) && !/^(blob|data):/.test(request.url()))
      sent.push(request.url());
  });
  const map = page.getByTestId('map');
  const colour = async () => (await countColours(page, map, [COLOURS.user]))[COLOURS.user] ?? 0;
  const before = await colour();
  const file = (name: string, buffer: Buffer) => ({ name, mimeType: 'application/octet-stream', buffer });
  await page.getByTestId('layer-file').setInputFiles(file('rivers.pmtiles', tilesOfOneArea()));
  await expect(page.getByTestId('user-layer')).toContainText('rivers.pmtiles');
  // The northern edge of the user's area crosses the whole map.
  const width = (await map.boundingBox())?.width ?? 0;
  await expect.poll(async () => (await colour()) - before, { timeout: 30_000 }).toBeGreaterThan(width / 4);
  await expectNoFaults(page, 'a layer of tiles');
  await page.getByTestId('layer-file').setInputFiles(file('bad.pmtiles', Buffer.from('no tiles here')));
  await expect(page.getByTestId('layer-fault')).toContainText('bad.pmtiles is not a PMTiles file');
  await page.getByTestId('user-layer').click();
  await expect(page.getByTestId('user-layer')).toHaveCount(0);
  await expect.poll(colour).toBeLessThan(before + width / 8);
  expect(sent).toEqual([]);
});

test('plans are compared, and panels are exported', async ({ page }) => {
  western();
  await open(page, '?t=70000&tab=plans');
  const { plans } = await ask<Plans>('plans?at=70000000000000');
  const shown = page.getByTestId('plans').locator('section');
  await expect(shown).toHaveCount(plans.length);
  const last = plans.at(-1);
  await expect(shown.first()).toContainText(last?.summary ?? '?');
  // The column shows what a visit lacks, to the second, and its tooltip the planner's reason, which rounds up to minutes.
  for (const left of last?.left_out ?? []) {
    const row = shown.first().getByTestId('left-out').locator(`tr[title="${left.reason}"]`);
    if (left.needs?.kind === 'time') {
      const { more_s, limit, alone } = left.needs;
      const seconds = Math.ceil(more_s);
      const parts = [Math.floor(seconds / 3600), Math.floor((seconds % 3600) / 60), seconds % 60];
      const words = parts
        .map((part, index) => (part ? `${part} ${['h', 'min', 's'][index]}` : ''))
        .filter(Boolean);
      await expect(row).toContainText(`${words.join(' ')} more than ${limit}${alone ? ', even alone' : ''}`);
      const minutes = Math.ceil(more_s / 60);
      const stated = /^needs (?:(\d+) h )?(\d+) min more/.exec(left.reason);
      if (stated) expect(Number(stated[1] ?? 0) * 60 + Number(stated[2])).toBe(minutes);
    } else if (left.reason.includes('window closes'))
      await expect(row).toContainText('one that closes later');
    else await expect(row).toContainText(left.reason);
  }
  await expectNoFaults(page, 'comparison of plans');

  const png = (bytes: Buffer) => expect(bytes.subarray(1, 4).toString()).toBe('PNG');
  png(await saved(page, 'export-map'));
  png(await saved(page, 'export-timeline'));
  // Exported drawings contain the texts and marks of the page, and no inline styles.
  const map = (await saved(page, 'export-map-svg')).toString();
  expect(map).toContain('href="data:image/png;base64,');
  const { targets } = await ask<Targets>('targets?at=70000000000000');
  const named = targets.filter(target => map.includes(`>${target.name}</text>`));
  const lost = Number.parseInt((await page.getByTestId('lost-labels').textContent()) ?? '0', 10);
  expect(named.length + lost).toBeGreaterThanOrEqual(targets.length);
  const timeline = (await saved(page, 'export-timeline-svg')).toString();
  await expectSvg(page, timeline);
  const rows = page.locator('[data-target]');
  const first = await rows.first().locator('.text').textContent();
  expect(timeline).toContain(`>${first}</text>`);
  expect(timeline.match(/class="planned/g)?.length ?? 0).toBeGreaterThan(0);
  expect(await saved(page, 'export-plans').then(String)).toContain(
    'plan,adopted_s,target,begin_s,end_s,left_out',
  );
  // The agenda has a row for each task that the server lists.
  const { tasks } = await ask<Tasks>('tasks?at=70000000000000&ended=true');
  const agenda = (await saved(page, 'export-agenda')).toString().trimEnd().split('\r\n');
  expect(agenda[0]).toBe('task,parent,depth,state,outcome,tag,goal');
  expect(agenda.length).toBe(tasks.length + 1);
  await page.locator('[data-task]').nth(2).click();
  await page.getByTestId('tab-why').click();
  const explained = await page.locator('[data-task]').nth(2).getAttribute('data-task');
  expect((await saved(page, 'export-why')).toString()).toContain(`T${explained} (`);
  await page.getByTestId('tab-signals').click();
  await expect(page.getByTestId('signals').locator('canvas').first()).toBeVisible();
  png(await saved(page, 'export-plots'));
  await expectSvg(page, (await saved(page, 'export-plots-svg')).toString());
  // The same samples as CSV and as Parquet, read by independent code.
  const text = (await saved(page, 'export-csv')).toString().split('\r\n').slice(1, -1);
  const bytes = await saved(page, 'export-parquet');
  const file = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength) as ArrayBuffer;
  const table = await parquetReadObjects({ file });
  expect(table.length).toBe(text.length);
  expect(`${table[5]?.signal},${table[5]?.unit},${table[5]?.time_s},${table[5]?.value}`).toBe(
    text[5]?.split(',').slice(0, 4).join(','),
  );
  await page.getByTestId('tab-log').click();
  await page.getByLabel('Find in the trace').fill('zaca');
  await expect(page.getByTestId('log')).toContainText('Zaca');
  const csv = (await saved(page, 'export-trace')).toString();
  expect(csv.split('\r\n')[0]).toBe('t_s,kind,task,before,after,outcome,subject,text,place');
  const times = csv
    .split('\r\n')
    .slice(1, -1)
    .map(line => Number(line.split(',')[0]));
  expect(times.length).toBeGreaterThan(5);
  expect(Math.max(...times)).toBeLessThanOrEqual(70_000);
});

test('the report is one page for paper with a small picture of every visit', async ({ page }) => {
  western();
  await page.goto(`${server.url}/?print=1`);
  const paper = page.getByTestId('paper');
  await expect(paper).toBeVisible({ timeout: 60_000 });
  const { targets } = await ask<Targets>(`targets?at=${mission.end_ns}`);
  const observed = targets.filter(target => target.history.some(change => change.state === 'observing'));
  expect(await paper.locator('figure').count()).toBeGreaterThanOrEqual(observed.length);
  await expect(paper).toContainText(`score ${mission.score?.toFixed(1)}`);
  for (const target of targets) await expect(paper).toContainText(target.name);
  await expectNoFaults(page, 'report');
  await page.emulateMedia({ media: 'print' });
  await expect(paper.getByRole('button', { name: 'Print' })).toBeHidden();
  const pdf = await page.pdf({ format: 'A4' });
  expect(pdf.subarray(0, 4).toString()).toBe('%PDF');
  // Before the end, the report knows no score and no later visit.
  await page.emulateMedia({ media: 'screen' });
  await page.goto(`${server.url}/?print=1&t=1`);
  await expect(page.getByTestId('paper')).toContainText('under way at this instant');
  await expect(page.locator('figure')).toHaveCount(0);
  await expect(page.getByTestId('paper')).not.toContainText('score');
});
