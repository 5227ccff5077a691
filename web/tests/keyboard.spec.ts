/** Keys and focus (K1 to K3): trees and grids have their own keys and one tab stop each, and the help holds the focus. */

import { expect, test } from '@playwright/test';
import { type Server, startServer } from './server';

let server: Server;
test.beforeAll(async () => {
  server = await startServer();
});
test.afterAll(() => server?.stop());

test('the keys of the agenda act on the tree, and leave the time cursor alone', async ({ page }) => {
  await page.goto(`${server.url}/?t=33432`);
  const tree = page.getByTestId('agenda');
  await expect(tree.getByRole('treeitem').first()).toBeVisible();
  const time = await page.getByTestId('time').textContent();
  const active = () => tree.getAttribute('aria-activedescendant');
  // Only rows in sight are drawn, below the filter and above the counts, which stay in sight.
  const inSight = async () => {
    const [list, slot] = await Promise.all([
      tree.evaluate(node => [node.clientHeight, node.scrollHeight]),
      page.getByTestId('slot-left').boundingBox(),
    ]);
    expect(list[0]).toBeLessThan(slot?.height ?? 0);
    expect(list[1], 'the list scrolls').toBeGreaterThan(2 * (list[0] ?? 0));
    expect(await tree.getByRole('treeitem').count()).toBeLessThan((list[0] ?? 0) / 23 + 18);
    await expect(page.locator('#task-filter')).toBeInViewport();
    await expect(tree.locator('xpath=following-sibling::footer')).toBeInViewport();
  };
  await inSight();
  await tree.focus();
  await page.keyboard.press('End');
  await expect.poll(active).toMatch(/^task-\d+$/);
  const last = await active();
  await expect(page.locator(`#${last}`)).toBeInViewport();
  await inSight();
  await page.keyboard.press('Home');
  await expect.poll(active).not.toBe(last);
  const root = tree.getByRole('treeitem').first();
  await expect(root).toHaveAttribute('aria-selected', 'true');
  expect(await active()).toBe(await root.getAttribute('id'));
  await page.keyboard.press('ArrowLeft');
  await expect(root).toHaveAttribute('aria-expanded', 'false');
  await page.keyboard.press('ArrowRight');
  await expect(root).toHaveAttribute('aria-expanded', 'true');
  await page.keyboard.press('ArrowRight');
  await expect(tree.getByRole('treeitem').nth(1)).toHaveAttribute('aria-selected', 'true');
  await tree.getByRole('treeitem').nth(2).click();
  await expect(tree).toBeFocused();
  await expect(page.getByTestId('time')).toHaveText(time ?? '');
});

test('rows of targets and lines of the trace are one tab stop each', async ({ page }) => {
  await page.goto(`${server.url}/?t=33432`);
  const grid = page.getByTestId('target-rows');
  await expect(grid.getByRole('row').nth(2)).toBeVisible();
  await expect(page.getByTestId('log').getByRole('row').nth(2)).toBeVisible();
  for (const box of [grid, page.getByTestId('log')]) {
    await expect(box.locator('button[tabindex="0"]')).toHaveCount(1);
    await expect(box.locator('button:not([tabindex])')).toHaveCount(0);
  }
  const time = await page.getByTestId('time').textContent();
  await grid.locator('button[tabindex="0"]').focus();
  await page.keyboard.press('ArrowDown');
  await expect(grid.getByRole('row').nth(1).getByRole('button')).toBeFocused();
  await page.keyboard.press('End');
  await expect(grid.getByRole('row').last().getByRole('button')).toBeFocused();
  await expect(grid.locator('button[tabindex="0"]')).toHaveCount(1);
  await expect(page.getByTestId('time')).toHaveText(time ?? '');
  // From the title of the page to the playback bar.
  await page.evaluate(() => (document.activeElement as HTMLElement).blur());
  let presses = 0;
  const reached = () =>
    page.evaluate(() => document.activeElement?.closest('[data-testid="playback"]') !== null);
  while (presses < 60 && !(await reached())) {
    await page.keyboard.press('Tab');
    presses += 1;
  }
  expect(presses, 'tab stops before the playback bar').toBeLessThan(55);
});

test('the help holds the focus and returns it', async ({ page }) => {
  await page.goto(`${server.url}/?t=33432`);
  const opener = page.getByTestId('copy-link');
  await opener.focus();
  await page.keyboard.press('?');
  const dialog = page.getByRole('dialog');
  await expect(dialog).toBeVisible();
  const time = await page.getByTestId('time').textContent();
  for (let press = 0; press < 4; press += 1) {
    await page.keyboard.press('Tab');
    // Beyond the last element the focus goes to the browser, which is the body of the page here.
    const inside = await page.evaluate(
      () => document.activeElement === document.body || document.activeElement?.closest('dialog') !== null,
    );
    expect(inside).toBe(true);
  }
  await page.keyboard.press('End');
  await expect(page.getByTestId('time')).toHaveText(time ?? '');
  await page.keyboard.press('Escape');
  await expect(dialog).toBeHidden();
  await expect(opener).toBeFocused();
});

test('the now line and the count of alarms do not state what could not be read', async ({ page }) => {
  let release: () => void = () => undefined;
  const held = new Promise<void>(resolve => {
    release = resolve;
  });
  await page.route('**/api/command-log*', async route => {
    await held;
    await route.continue();
  });
  await page.route('**/api/holdings*', route =>
    route.fulfill({
      status: 500,
      contentType: 'application/json',
      body: '{"error":"disk gone","help":"replace it"}',
    }),
  );
  await page.goto(`${server.url}/?t=33432`);
  await expect(page.getByTestId('now')).toHaveText(/could not be read/);
  await expect(page.getByTestId('now')).not.toHaveText(/no task holds/);
  await expect(page.getByTestId('calls')).toHaveText(/at least \d+ alarms?/);
  release();
  await expect(page.getByTestId('calls')).toHaveText(/^▲ \d+ alarms?/);
});
