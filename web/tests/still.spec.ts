/**
 * Nothing on the page moves because the time cursor moves, rests or plays: texts of an instant come and go in places that are always there,
 * so that a click that was aimed before hits what it was aimed at.
 */

import { existsSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { expect, type Page, test } from '@playwright/test';
import { startServer } from './server';

const SCREENS = [
  [1280, 720],
  [1920, 1080],
  [820, 1180],
  [390, 844],
] as const;

interface Watched {
  /** The different places of each part since the watch began. */
  places: Record<string, string[]>;
  /** What the browser reported as shifted. */
  shifts: string[];
  frames: number;
}

/** Notes in each frame where the parts and controls of the page are, and all layout shifts. */
function watch(page: Page): Promise<void> {
  return page.evaluate(() => {
    const watched: Watched = { places: {}, shifts: [], frames: 0 };
    const before = (window as unknown as { still?: { stop: () => void } }).still;
    before?.stop();
    // Rows of lists are data, which come and go; everything around them is watched.
    const isListed = (node: Element) =>
      node.closest('[role="tree"], table, [role="log"], [role="grid"], [role="tabpanel"] > *') !== null;
    const nameOf = (node: Element) =>
      node.getAttribute('data-testid') ??
      node.getAttribute('aria-label') ??
      `${node.tagName.toLowerCase()}.${node.getAttribute('class')}: ${node.textContent?.trim().slice(0, 30)}`;
    const parts = () => [
      ...document.querySelectorAll(
        'header, [data-testid="now"], main, main section, main canvas, [data-testid="timeline"], [role="tabpanel"], .bars > section, header > *, header button, [role="tab"], nav button, .tools button, .kinds button, .transport button, .notices',
      ),
    ];
    const note = () => {
      watched.frames += 1;
      for (const node of parts()) {
        if (isListed(node) || node.matches('[data-testid="calls"]')) continue;
        const box = node.getBoundingClientRect();
        if (box.width === 0) continue;
        const place = [box.left, box.top, box.width, box.height].map(Math.round).join(' ');
        watched.places[nameOf(node)] ??= [];
        const places = watched.places[nameOf(node)] ?? [];
        if (!places.includes(place)) places.push(place);
      }
      frame = requestAnimationFrame(note);
    };
    let frame = requestAnimationFrame(note);
    type Shift = PerformanceEntry & {
      sources: { node: Node | null; previousRect: DOMRect; currentRect: DOMRect }[];
    };
    const observer = new PerformanceObserver(list => {
      for (const { sources } of list.getEntries() as Shift[]) {
        for (const { node, previousRect, currentRect } of sources) {
          const element = node instanceof Element ? node : node?.parentElement;
          // Words are data, too: they may move within their place, and marks of time move in time.
          if (!element?.isConnected || isListed(element)) continue;
          if (
            element.closest(
              '[data-testid="now"], .notices, .notes, .legend, .credit, .value, .tip, .future, .thumb, [data-testid="cursor"]',
            )
          )
            continue;
          const [from, to] = [previousRect, currentRect].map(
            rect => `${Math.round(rect.x)} ${Math.round(rect.y)}`,
          );
          if (from !== to) watched.shifts.push(`${nameOf(element)} from ${from} to ${to}`);
        }
      }
    });
    observer.observe({ type: 'layout-shift', buffered: false });
    const stop = () => {
      cancelAnimationFrame(frame);
      observer.disconnect();
    };
    Object.assign(window, { still: { watched, stop } });
  });
}

const seen = (page: Page) =>
  page.evaluate(() => (window as unknown as { still: { watched: Watched } }).still.watched);

/** Goes to an instant as the Back key does, and waits until all parts of the page show it. */
async function goTo(page: Page, seconds: number): Promise<void> {
  const answered = page.waitForResponse(response => response.url().includes('/api/tasks?'));
  await page.evaluate(instant => {
    window.history.replaceState(null, '', `?t=${instant}`);
    window.dispatchEvent(new PopStateEvent('popstate'));
  }, seconds);
  await answered;
  await expect(page.getByTestId('late')).toHaveCount(0);
}

async function expectStill(page: Page, where: string): Promise<void> {
  const { places, shifts, frames } = await seen(page);
  expect(frames, `frames, ${where}`).toBeGreaterThan(10);
  expect(Object.keys(places).length, `parts, ${where}`).toBeGreaterThan(20);
  const moved = Object.entries(places).filter(([, all]) => all.length > 1);
  expect(moved, `parts that moved, ${where}`).toEqual([]);
  expect(shifts, `layout shifts, ${where}`).toEqual([]);
}

const RECORDS = [
  ['structure-watch', SCREENS],
  // More targets and notes, which need most space on these screens.
  ['western-states', [SCREENS[0], SCREENS[3]]],
] as const;

for (const [name, screens] of RECORDS) {
  test(`no part of the page moves while the cursor moves, rests and plays: ${name}`, async ({ page }) => {
    const record = join(dirname(process.env.APEX_RECORD ?? ''), `${name}.apex`);
    test.skip(!existsSync(record), `needs ${record}`);
    test.setTimeout(300_000);
    const server = await startServer(record);
    try {
      const { end_ns } = (await (await fetch(`${server.url}/api/mission`)).json()) as { end_ns: number };
      const endS = end_ns / 1e9;
      const asked = await fetch(`${server.url}/api/questions?at=${end_ns}`);
      const [question] = ((await asked.json()) as { questions: { asked_ns: number }[] }).questions;
      const askedS = Math.ceil((question?.asked_ns ?? 0) / 1e9) + 10;
      await page.goto(`${server.url}/?t=${Math.round(endS / 3)}`);
      await expect(page.locator('[data-task]').first()).toBeAttached();
      for (const [width, height] of screens) {
        await page.setViewportSize({ width, height });
        await goTo(page, Math.round(endS / 3));
        await watch(page);
        for (const key of ['ArrowRight', 'ArrowRight', 'ArrowLeft', 'Shift+ArrowRight', 'Shift+ArrowLeft']) {
          await page.keyboard.press(key);
        }
        for (const share of [0, 0.26, 0.6, 0.95]) await goTo(page, Math.floor(endS * share));
        await goTo(page, askedS);
        await expect(page.getByTestId('open-question')).toBeVisible();
        await goTo(page, Math.floor(endS));
        await expect(page.getByTestId('open-question')).toHaveCount(0);
        await goTo(page, Math.round(endS * 0.2));
        const time = await page.getByTestId('time').textContent();
        await page.keyboard.press('Space');
        await expect(page.getByTestId('time')).not.toHaveText(time ?? '');
        const { frames } = await seen(page);
        await expect
          .poll(async () => (await seen(page)).frames, { timeout: 60_000 })
          .toBeGreaterThan(frames + 30);
        // Also ends the playback, unless the record has ended it.
        await page.keyboard.press('End');
        await expect(page.getByTestId('status')).toHaveText('ended');
        await expect(page.getByTestId('late')).toHaveCount(0);
        await expectStill(page, `${width}x${height}`);
      }
    } finally {
      server.stop();
    }
  });
}
