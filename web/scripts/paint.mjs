// Measures the time from a key to the next paint of Sherpa while a record plays:
// node scripts/paint.mjs APEX RECORD [PRESSES]
// Makes the record first if it does not exist: western-states with 200 targets and 1,000 steps that work at the same time, eight hours
// long. The page plays it at 600 times and at 60 times the speed of the flight, 10 moves of its cursor a second or more, with Chromium's
// software rendering; then keys move the cursor of the paused page, ten a second, with the map's drawing of each instant. Times are those of the browser's own event timing; the machine should have nothing else to do.

import { spawn, spawnSync } from 'node:child_process';
import { cpSync, existsSync, mkdtempSync, readFileSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { chromium } from '@playwright/test';
import { launchOptions, viewport } from '../tests/browser.mjs';

const [apex, record, presses = '200'] = process.argv.slice(2);
if (!apex || !record) {
  console.error('usage: node scripts/paint.mjs APEX RECORD [PRESSES]');
  process.exit(2);
}
const [TARGETS, TASKS, HOURS] = [200, 1000, 8];
/** Ten keys a second, after the map has loaded. */
const [EVERY_MS, LOAD_MS, BAR_MS] = [100, 5000, 200];
const missions = new URL('../../missions/', import.meta.url).pathname;

if (!existsSync(record)) makeRecord();
const server = spawn(apex, ['serve', record, '--port', '0'], { stdio: ['ignore', 'pipe', 'inherit'] });
const url = await new Promise((resolve, reject) => {
  server.on('exit', code => reject(new Error(`the server ended with ${code}`)));
  server.stdout.on('data', data => {
    const found = /http:\/\/[^\s/]+/.exec(String(data));
    if (found) resolve(found[0]);
  });
});
try {
  await measure();
} finally {
  server.kill('SIGTERM');
}

async function measure() {
  const { counts } = await ask(`tasks?at=${10800e9}&limit=2000`);
  const { targets } = await ask(`targets?at=${10800e9}`);
  console.log(`${targets.length} targets; tasks at 3 h: ${JSON.stringify(counts)}`);
  const browser = await chromium.launch(launchOptions);
  for (const speed of [60, 600]) {
    const page = await open(browser);
    await chooseSpeed(page, speed);
    const before = await shownS(page);
    await page.getByTestId('play').click();
    const paints = await paintsAfter(page, ['+', '-']);
    const played = (await shownS(page)) - before;
    report(`${speed} times the speed: ${presses} keys while ${played.toFixed(0)} s played`, paints);
    await page.close();
  }
  const page = await open(browser);
  report(
    `paused: ${presses} keys that move the cursor`,
    await paintsAfter(page, ['ArrowRight', 'ArrowLeft']),
  );
  await browser.close();
}

/** Opens the page at two hours; it notes the times from keys to paints. */
async function open(browser) {
  const page = await browser.newPage({ viewport });
  await page.goto(`${url}/?t=7200`);
  await page.waitForTimeout(LOAD_MS);
  await page.evaluate(() => {
    window.paints = [];
    new PerformanceObserver(list => {
      for (const entry of list.getEntries()) if (entry.name === 'keydown') window.paints.push(entry.duration);
    }).observe({ type: 'event', durationThreshold: 16, buffered: false });
  });
  return page;
}

/**
 * Presses the keys in turn, ten a second, and returns the sorted times until the next paint, and the time of the page's main thread per
 * key, which other programs of the machine hardly change, in milliseconds.
 */
async function paintsAfter(page, keys) {
  const session = await page.context().newCDPSession(page);
  await session.send('Performance.enable', { timeDomain: 'threadTicks' });
  const busyMs = async () => {
    const { metrics } = await session.send('Performance.getMetrics');
    return 1000 * (metrics.find(metric => metric.name === 'TaskDuration')?.value ?? 0);
  };
  const before = await busyMs();
  for (let press = 0; press < Number(presses); press += 1) {
    await page.keyboard.press(keys[press % keys.length]);
    await page.waitForTimeout(EVERY_MS);
  }
  // The browser does not report events below 16 ms: they are counted as 16 ms.
  const reported = await page.evaluate(() => window.paints);
  const missing = Array(Math.max(Number(presses) - reported.length, 0)).fill(16);
  const paints = [...reported, ...missing].sort((a, b) => a - b);
  return { paints, busyMs: ((await busyMs()) - before) / Number(presses) };
}

function report(what, { paints, busyMs }) {
  const share = part => paints[Math.min(Math.floor(paints.length * part), paints.length - 1)];
  console.log(
    `${what}: median ${share(0.5)} ms, p95 ${share(0.95)} ms, longest ${paints.at(-1)} ms (bar ${BAR_MS} ms at p95), main thread ${busyMs.toFixed(0)} ms per key`,
  );
}

/** The instant that the page shows, in seconds of mission time. */
async function shownS(page) {
  const [hours = 0, minutes = 0, seconds = 0] = ((await page.getByTestId('time').textContent()) ?? '')
    .replace(/^T\+/, '')
    .split(':')
    .map(Number);
  return hours * 3600 + minutes * 60 + seconds;
}

/** Presses "Faster" or "Slower" until the playback shows a speed. */
async function chooseSpeed(page, speed) {
  const shown = page.getByTestId('playback').locator('.speed .mono');
  for (let press = 0; press < 20; press += 1) {
    const now = Number(/\d+/.exec((await shown.textContent()) ?? '')?.[0] ?? 0);
    if (now === speed) return;
    await page.getByLabel(now < speed ? 'Faster' : 'Slower').click();
  }
  throw new Error(`the playback has no speed of ${speed}`);
}

async function ask(query) {
  const response = await fetch(`${url}/api/${query}`);
  if (!response.ok) throw new Error(`${query}: ${response.status} ${await response.text()}`);
  return response.json();
}

/** Flies western-states with other targets and with steps that only work. */
function makeRecord() {
  const folder = mkdtempSync(join(tmpdir(), 'apex-paint-'));
  cpSync(join(missions, 'western-states'), folder, { recursive: true });
  const across = 20;
  const features = Array.from({ length: TARGETS }, (_, place) => ({
    type: 'Feature',
    properties: {
      id: `spot-${place}`,
      name: `Spot ${place}`,
      kind: 'fire',
      acres: 400,
      value: 10 + (place % 7),
      elevation_m: 1200,
    },
    geometry: {
      type: 'Point',
      coordinates: [-121 + 0.4 * (place % across), 35 + 0.6 * Math.floor(place / across)],
    },
  }));
  writeFileSync(join(folder, 'fires.geojson'), JSON.stringify({ type: 'FeatureCollection', features }));
  writeFileSync(join(folder, 'scenario.jsonl'), '');
  const steps = Array.from(
    { length: TASKS },
    (_, task) => `  (step lane-${task} (work ${task}) (repeating))`,
  );
  const program = readFileSync(join(folder, 'mission.pdl'), 'utf8')
    .replace(':duration 24h', `:duration ${HOURS}h`)
    .replace('(step touch ', '(step work (work in lanes))\n  (step touch ');
  const lanes = `(procedure (index (work in lanes))\n${steps.join('\n')})\n(primitive (index (work ?lane)) (duration (+ 60s (* ?lane 1s))))\n`;
  writeFileSync(join(folder, 'mission.pdl'), `${program}\n${lanes}`);
  const flight = spawnSync(apex, ['fly', folder, '--record', record, '--no-progress'], {
    stdio: ['ignore', 'ignore', 'inherit'],
  });
  if (flight.status !== 0) throw new Error(`apex fly ended with ${flight.status}`);
}
