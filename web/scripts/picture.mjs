// Takes the picture of the README: node scripts/picture.mjs URL FILE.png [SHARE OF THE FLIGHT] [TEXT OF A TASK]

import { chromium } from '@playwright/test';
import { launchOptions, viewport } from '../tests/browser.mjs';

const [url, file, share = '0.5', goal] = process.argv.slice(2);
if (!url || !file) {
  console.error('usage: node scripts/picture.mjs URL FILE.png [SHARE OF THE FLIGHT] [TEXT OF A TASK]');
  process.exit(2);
}
/** The width of the timeline's column of names, and time for the map to load. */
const [NAMES_PX, LOAD_MS, SETTLE_MS] = [168, 4000, 800];

const browser = await chromium.launch(launchOptions);
const page = await browser.newPage({ viewport });
await page.goto(url);
await page.waitForTimeout(LOAD_MS);
const box = await page.getByTestId('timeline').boundingBox();
await page.mouse.click(box.x + NAMES_PX + (box.width - NAMES_PX) * Number(share), box.y + 26);
if (goal) {
  await page.locator('#task-filter').fill(goal);
  await page.locator('[data-task]').filter({ hasText: goal }).last().click();
  await page.locator('#task-filter').fill('');
  await page.keyboard.press('Escape');
}
await page.mouse.move(box.x + 40, box.y + 26);
await page.waitForTimeout(SETTLE_MS);
await page.screenshot({ path: file });
await browser.close();
