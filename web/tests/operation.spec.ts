/**
 * Operating a flight: a paused flight of structure-watch is run, stepped, answered and changed from the page. The record must hold every
 * command with exactly one end.
 */

import { type ChildProcess, execFileSync, spawn } from 'node:child_process';
import { mkdtempSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { expect, type Page, test } from '@playwright/test';
import type { Operation } from '../src/record/types';
import { COLOURS } from '../src/theme/colours';
import { expectNoFaults } from './axe';
import { countColours } from './pixels';
import { addressOf, apexProgram } from './server';

const MISSION = fileURLToPath(new URL('../../missions/structure-watch', import.meta.url));

interface Flight {
  url: string;
  record: string;
  process: ChildProcess;
}

let flight: Flight;

async function fly(more: string[]): Promise<Flight> {
  const record = join(mkdtempSync(join(tmpdir(), 'sherpa-')), 'flight.apex');
  const process = spawn(
    apexProgram(),
    ['fly', MISSION, '--serve', '--port', '0', '--no-progress', '--record', record, ...more],
    { stdio: ['ignore', 'pipe', 'pipe'] },
  );
  return { url: await addressOf(process), record, process };
}

async function operation(): Promise<Operation> {
  return (await fetch(`${flight.url}/api/operation`)).json() as Promise<Operation>;
}

/** All inputs of the record that are commands. */
function recorded(): string[] {
  const out = execFileSync(apexProgram(), ['trace', flight.record, '--json'], { maxBuffer: 1 << 28 });
  return out
    .toString()
    .split('\n')
    .filter(line => line.includes('operator-command'))
    .map(line => JSON.parse(line).event?.toString() ?? line);
}

async function lastCommand(page: Page, words: string): Promise<void> {
  await expect(page.getByTestId('last-command')).toContainText(words);
}

// One flight for all tests of this file.
test.describe.configure({ mode: 'default' });
test.beforeAll(async () => {
  flight = await fly(['--paused', '--pace', '100']);
});
test.afterAll(() => {
  flight?.process.kill('SIGKILL');
});

test('a flight is run, stepped, answered and changed from the page, and the record holds it', async ({
  page,
}) => {
  test.setTimeout(180_000);
  await page.goto(flight.url);
  const state = page.getByTestId('run-state');
  await expect(state).toHaveText('paused');
  await expectNoFaults(page, 'paused before the start');

  // Step: one thing happens, and time stands still again.
  await page.getByTestId('run-step').click();
  await lastCommand(page, 'step: accepted');
  await expect(state).toHaveText('paused');

  // The question of the start has a radio group or a field; a wrong message is rejected with its reason.
  await page.getByTestId('message').fill('hello');
  await page.getByTestId('message').press('Enter');
  await lastCommand(page, 'rejected: the message is hello; expected a form');
  const colour = await page.getByTestId('last-command').evaluate(node => getComputedStyle(node).color);
  expect(colour).toBe('rgb(255, 138, 101)');

  await page.getByTestId('run-pace').selectOption('120');
  await lastCommand(page, 'pace 120: accepted');
  // Requests to planners come and go, and the buttons stay.
  const step = page.getByTestId('run-step');
  await step.evaluate(node => {
    const lefts = new Set<number>();
    Object.assign(window, { lefts });
    const note = () => {
      lefts.add(node.getBoundingClientRect().left);
      requestAnimationFrame(note);
    };
    note();
  });
  await expect.poll(async () => (await operation()).now_ns, { timeout: 30_000 }).toBeGreaterThan(500e9);
  await page.getByTestId('run-pause').click();
  await expect(state).toHaveText('paused');
  expect(await page.evaluate(() => (window as unknown as { lefts: Set<number> }).lefts.size)).toBe(1);
  const { now_ns: paused } = await operation();
  await page.waitForTimeout(600);
  expect((await operation()).now_ns, 'mission time stands still').toBe(paused);

  // A target gets another value, is removed, and is added again.
  await page.goto(`${flight.url}/?sel=target:winery`);
  await page.getByTestId('target-value').fill('77');
  await page.getByTestId('target-revalue').click();
  await lastCommand(page, 'value of target winery: 77: accepted');
  await page.goto(`${flight.url}/?sel=target:sawmill`);
  await page.getByTestId('target-remove').click();
  await lastCommand(page, 'remove target sawmill: accepted');
  await page.getByTestId('target-add').selectOption('sawmill');
  await lastCommand(page, 'add target sawmill: accepted');

  // The question about the smoke, at 28 minutes, has options, a default and a deadline; the answer is in the record.
  await page.getByTestId('run-pause').click();
  // Asked often, so that the flight is not far beyond this time, and soon at the question.
  await expect
    .poll(async () => (await operation()).now_ns, { timeout: 60_000, intervals: [100] })
    .toBeGreaterThan(1600e9);
  await page.getByTestId('run-pace').selectOption('10');
  const question = page.getByTestId('question').filter({ hasText: 'Smoke at a structure' });
  await expect(question).toBeVisible({ timeout: 60_000 });
  await page.getByTestId('run-pause').click();
  await expect(state).toHaveText('paused');
  await expect(question.getByRole('radio')).toHaveCount(2);
  await expect(question.getByTestId('deadline')).toContainText('fire is taken in');
  await expectNoFaults(page, 'a question is open');
  const att = await countColours(page, question, [COLOURS.att]);
  expect(att[COLOURS.att] ?? 0, 'an open question has the colour of attention').toBeGreaterThan(20);
  await question.getByRole('radio').nth(1).check();
  await question.getByTestId('answer').click();
  await lastCommand(page, 'barbecue: accepted');
  await expect(question).toHaveCount(0);
  const answered = page.getByTestId('alarms').locator('li').filter({ hasText: 'Smoke at a structure' });
  await page.goto(`${flight.url}/?tab=alarms`);
  await expect(answered).toContainText('answered barbecue');

  await page.getByTestId('run-stop').click();

  await page.getByTestId('stop-confirm').click();
  await expect(page.getByTestId('operator')).toHaveCount(0);
  await expect(page.getByTestId('status')).toHaveAttribute('title', 'it was stopped from outside');

  const commands = recorded().join('\n');
  for (const entry of [
    '"step" accepted',
    'pace 120" accepted',
    'message: hello" rejected',
    'winery: 77" accepted',
    'remove target sawmill" accepted',
    'add target sawmill" accepted',
    'barbecue" accepted',
    '"stop" accepted',
  ])
    expect(commands.replaceAll('\\"', '"')).toContain(entry);
  execFileSync(apexProgram(), ['replay', flight.record], { stdio: 'pipe' });
});

test('a command to a silent server shows its age, and expires', async ({ page }) => {
  test.setTimeout(120_000);
  const silent = await fly(['--paused', '--pace', '30']);
  try {
    await page.goto(silent.url);
    await page.getByTestId('run-pause').click();
    await lastCommand(page, 'resume: accepted');
    silent.process.kill('SIGSTOP');
    await page.getByTestId('run-pause').click();
    const sent = page.getByTestId('sent-command');
    await expect(sent).toHaveText(/^pause: sent [1-9]\.\d s$/);
    await expect(page.getByTestId('last-command')).toHaveCount(0);
    await expect(sent).toHaveText(/^pause: expired after 10 s: the server does not answer/);
    silent.process.kill('SIGCONT');
    // The server reads the command when it continues: the command has expired, and the flight continues.
    await lastCommand(page, 'pause: expired');
    await expect(sent).toHaveCount(0);
    await expect(page.getByTestId('run-state')).not.toHaveText('paused');
  } finally {
    silent.process.kill('SIGKILL');
  }
});
