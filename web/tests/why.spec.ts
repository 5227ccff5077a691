/** The explanation as a tree, compared with `apex why` on the record. */

import { execFileSync } from 'node:child_process';
import { expect, test } from '@playwright/test';
import type { Link, Why } from '../src/record/types';
import { expectNoFaults } from './axe';
import { apexProgram, type Server, startServer } from './server';

const RECORD = process.env.APEX_RECORD ?? '';
let server: Server;

test.beforeAll(async () => {
  server = await startServer();
});
test.afterAll(() => server?.stop());

function apex(...options: string[]): string {
  return execFileSync(apexProgram(), options, { encoding: 'utf8', maxBuffer: 1 << 28 });
}

/** The first task that the mission started because of a run of samples, and when. */
function answer(): { task: string; at: number; variable: string } | undefined {
  const lines = apex('trace', RECORD, '--json', '--type', 'satisfied').split('\n').filter(Boolean);
  const line = lines.find(text => /samples in/.test(text) && /\((roll-angle|signal-level)/.test(text));
  const parts = JSON.parse(line ?? '{}') as { t?: number; task?: string | number };
  const variable = /\((?:roll-angle|signal-level) [^)]+\)/.exec(line ?? '')?.[0];
  const task = /\d+$/.exec(String(parts.task ?? ''))?.[0];
  return parts.t === undefined || !task || !variable ? undefined : { task, at: parts.t, variable };
}

function links(link: Link | null): Link[] {
  return link ? [link, ...link.causes.flatMap(links)] : [];
}

test('a cause is a tree of words with the values that it rests on, and leads to the samples', async ({
  page,
}) => {
  const found = answer();
  test.skip(!found, 'needs a flight that answered a run of samples');
  const { task, at, variable } = found as NonNullable<typeof found>;
  const seconds = at + 0.001;
  const why = JSON.parse(apex('why', RECORD, `T${task}`, '--at', `${seconds.toFixed(3)}s`, '--json')) as Why;
  await page.goto(`${server.url}/?t=${seconds.toFixed(3)}&sel=task:${task}`);
  const tree = page.getByTestId('why-tree');
  await expect(tree).toBeVisible();
  const causes = tree.locator('[data-node^="because"]:not([data-node*=".e"])');
  await expect(causes).toHaveCount(links(why.because).length);
  await expect(tree).not.toContainText('((');
  const run = links(why.because)
    .flatMap(link => link.cause?.evidence ?? [])
    .find(one => one.type === 'run' && one.variable === variable);
  if (run?.type !== 'run') throw new Error('the explanation names no run of samples');
  const leaf = tree
    .locator('[role=treeitem]')
    .filter({ has: page.getByTestId('plot-leaf') })
    .first();
  await expect(leaf).toContainText(`${run.samples} samples`);
  // The values of the run: of the lines of the trace, which the page does not read.
  const lines = apex(
    ...['trace', RECORD, '--json', '--type', 'measurement', '--object', variable],
    ...['--from', `${run.from}s`, '--to', `${run.to}s`],
  );
  const values = [...lines.matchAll(/"value":"?(-?[\d.]+(?:e-?\d+)?)/g)].map(match => Number(match[1]));
  const shown = leaf.locator('b');
  await expect(shown).toHaveText(/ to /);
  const [low, high] = ((await shown.textContent()) ?? '').split(' to ').map(Number.parseFloat);
  expect(low).toBeCloseTo(Math.min(...values), 1);
  expect(high).toBeCloseTo(Math.max(...values), 1);

  await leaf.getByTestId('plot-leaf').click();
  await expect(page.getByTestId('signal')).toHaveAttribute('data-signal', variable.slice(1, -1));
  await expect(page).toHaveURL(/tab=signals/);
});

test('the tree is moved in by keys, and shows arguments on demand', async ({ page }) => {
  const found = answer();
  test.skip(!found, 'needs a flight that answered a run of samples');
  await page.goto(`${server.url}/?t=${found?.at.toFixed(3)}&sel=task:${found?.task}`);
  const items = page.getByTestId('why-tree').locator('[role=treeitem]');
  await expect(items.nth(1)).toBeVisible();
  const count = await items.count();
  await items.first().focus();
  await page.keyboard.press('ArrowLeft');
  await expect.poll(() => items.count()).toBeLessThan(count);
  await page.keyboard.press('ArrowRight');
  await expect(items).toHaveCount(count);
  await page.keyboard.press('Enter');
  await expect(page.getByTestId('arguments')).toContainText('(');
  await expectNoFaults(page, 'why tree with arguments');
});
