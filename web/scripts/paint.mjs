// Measures the time from a key to the next paint while the record plays: node scripts/paint.mjs URL [PRESSES]
// By the browser's own event timing; the machine should have nothing else to do.

import { chromium } from '@playwright/test';
import { launchOptions, viewport } from '../tests/browser.mjs';

const [url, presses = '100'] = process.argv.slice(2);
if (!url) {
  console.error('usage: node scripts/paint.mjs URL [PRESSES]');
  process.exit(2);
}
/** Ten keys a second, after the map has loaded. */
const [EVERY_MS, LOAD_MS, BAR_MS] = [100, 5000, 200];

const browser = await chromium.launch(launchOptions);
const page = await browser.newPage({ viewport });
await page.goto(url);
await page.waitForTimeout(LOAD_MS);
await page.evaluate(() => {
  window.paints = [];
  new PerformanceObserver(list => {
    for (const entry of list.getEntries()) if (entry.name === 'keydown') window.paints.push(entry.duration);
  }).observe({ type: 'event', durationThreshold: 16, buffered: false });
});
await page.getByTestId('play').click();
for (let press = 0; press < Number(presses); press += 1) {
  await page.keyboard.press(press % 2 === 0 ? '+' : '-');
  await page.waitForTimeout(EVERY_MS);
}
const paints = (await page.evaluate(() => window.paints)).sort((a, b) => a - b);
const at = share => paints[Math.min(Math.floor(paints.length * share), paints.length - 1)] ?? 0;
// The browser does not report those below 16 ms.
console.log(
  `${presses} keys, ${paints.length} took 16 ms or more: median ${at(0.5)} ms, p95 ${at(0.95)} ms; the bar is ${BAR_MS} ms`,
);
await browser.close();
