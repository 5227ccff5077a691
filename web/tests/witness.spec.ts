/**
 * The page at random instants against `apex trace`: states, goals and bindings of tasks, holders, plans, targets, alarms and questions.
 * SHERPA_SEED=n draws other instants; a failure names its record, instant and seed.
 */

import { execFileSync } from 'node:child_process';
import { existsSync, mkdtempSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { expect, type Locator, type Page, test } from '@playwright/test';
import { apexProgram, startServer } from './server';
import { numbers, traceOf, type Witness, witnessAt } from './witness';

const SEED = Number(process.env.SHERPA_SEED ?? 1);
/** Instants of each record: 30 in all. */
const INSTANTS = 6;
/** A record of the flights. */
function flight(name: string): string {
  const record = join(dirname(process.env.APEX_RECORD ?? ''), `${name}.apex`);
  test.skip(!existsSync(record), `needs ${record}: make flights`);
  return record;
}

/** Runs `apex` in a new folder; a run that fails has another exit status. */
function made(name: string, args: (record: string, folder: string) => string[]): string {
  const folder = mkdtempSync(join(tmpdir(), 'sherpa-'));
  const record = join(folder, name);
  try {
    execFileSync(apexProgram(), args(record, folder), { stdio: 'ignore' });
  } catch (error) {
    if (!existsSync(record)) throw error;
  }
  return record;
}

/** A run with a question that is answered, one that expires, an interrupted task, and an initial task that fails. */
const FAILING = `
(procedure (index (do-domain))
  (step low (hold low) (priority 1))
  (step high (hold high) (priority 5) (waitfor (go)))
  (step ask (ask operator "Continue?" :options (yes no) :by 30s :default no) (waitfor (go)))
  (step again (ask operator "Again?" :options (yes no) :by 10s :default no) (waitfor (end ?ask)))
  (step late (hold late) (waitfor (go)) (skip-when (end ?ask)))
  (step short (watch short) (exit-when (altitude uav < 250)))
  (step unready (watch unready) (waitfor (end ?ask)) (precondition (gear main = down)))
  (step kept (watch kept) (invariant (altitude uav > 300)))
  (step noted (hold spare) (waitfor (precondition-failed ?unready) (invariant-violated ?kept)))
  (step end (order) (waitfor (stop))))
(procedure (index (order)) (step no (terminate failure)))
(primitive (index (hold ?how)) (profile voice) (duration 25s))
(primitive (index (watch ?what)) (duration 50s))
`;

function failedRun(): string {
  return made('failed.apex', (record, folder) => {
    const [program, inputs] = [join(folder, 'run.pdl'), join(folder, 'inputs.jsonl')];
    writeFileSync(program, FAILING);
    writeFileSync(
      inputs,
      [
        '{"t": 2, "measurement": "(altitude uav)", "value": 310}',
        '{"t": 5, "event": "(go)"}',
        '{"t": 20, "answer": 0, "value": "yes"}',
        '{"t": 22, "measurement": "(altitude uav)", "value": 200}',
        '{"t": 60, "event": "(stop)"}\n',
      ].join('\n'),
    );
    return ['run', program, '--inputs', inputs, '--record', record];
  });
}

/** The texts of elements, with single spaces. */
const wordsOf = async (nodes: Locator) =>
  (await nodes.allTextContents()).map(text => text.replace(/\s+/g, ' ').trim());

/** All rows of the agenda by their numbers: only those in sight are drawn, so the list is scrolled from its top to its end. */
async function agendaRows(page: Page) {
  return page.getByTestId('agenda').evaluate(async list => {
    const rows = new Map<string, { task: string; state: string; word: string; goal: string }>();
    const drawn = () => new Promise(resolve => requestAnimationFrame(() => requestAnimationFrame(resolve)));
    for (let top = 0; top < list.scrollHeight; top += list.clientHeight) {
      list.scrollTop = top;
      await drawn();
      for (const node of list.querySelectorAll('[data-task]')) {
        const task = `T${node.getAttribute('data-task')}`;
        rows.set(task, {
          task,
          state: node.getAttribute('data-state') ?? '',
          word: node.querySelector('.state')?.textContent ?? '',
          goal: node.querySelector('.goal')?.getAttribute('title') ?? '',
        });
      }
    }
    list.scrollTop = 0;
    return { rows: [...rows.values()], count: Math.round((list.firstElementChild?.clientHeight ?? 0) / 23) };
  });
}

/** Compares the rows of the agenda, and the counts below them. */
async function compareTasks(page: Page, seen: Witness, where: string): Promise<void> {
  const counts = new Map<string, number>();
  for (const { state } of seen.tasks.values()) {
    const word = state === 'terminated' ? 'ended' : state;
    counts.set(word, (counts.get(word) ?? 0) + 1);
  }
  const expected = [...counts].map(([state, count]) => `${count} ${state}`).sort();
  const footer = page.getByTestId('agenda').locator('xpath=following-sibling::footer/span');
  await expect
    .poll(async () => (await wordsOf(footer)).filter(text => !text.endsWith('not shown')).sort(), {
      message: where,
    })
    .toEqual(expected);
  const { rows, count } = await agendaRows(page);
  expect(rows.length, `rows of the agenda, ${where}`).toBe(count);
  expect(rows.length, where).toBeGreaterThan(0);
  const words: Record<string, string> = {
    success: 'done',
    failure: 'failed',
    'precondition failed': 'failed',
    'invariant violated': 'failed',
    cut: 'cut',
    skipped: 'skipped',
    exited: 'exited',
  };
  for (const row of rows) {
    const known = seen.tasks.get(row.task);
    expect({ ...row, known: known !== undefined }, `${row.task}, ${where}`).toEqual({
      task: row.task,
      known: true,
      state: known?.state,
      word: known?.state === 'terminated' ? words[known.outcome ?? ''] : known?.state,
      goal: `${row.task}  ${known?.goal}`,
    });
  }
}

async function compareHolders(page: Page, seen: Witness, where: string): Promise<void> {
  const rows = page.getByTestId('resource-rows').locator('[role="row"] [role="gridcell"]:first-child');
  await expect(rows, where).toHaveCount(seen.resources.size);
  for (const title of await rows.evaluateAll(nodes => nodes.map(node => node.getAttribute('title') ?? ''))) {
    const [, resource = '', holder = ''] = /^(.+): (T\d+|free)/.exec(title) ?? [];
    const holders = [...seen.tasks].filter(([, task]) => task.holds.includes(resource)).map(([id]) => id);
    expect(holders.length === 0 ? ['free'] : holders, `${title}, ${where}`).toContain(holder);
  }
}

async function compareTargets(page: Page, seen: Witness, known: number, where: string): Promise<void> {
  const progress = page.getByTestId('progress');
  if (known + seen.announced.size === 0) return expect(progress, where).toHaveCount(0);
  await expect(progress, where).toHaveText(
    new RegExp(`^${seen.observed.size} of ${known + seen.announced.size} targets`),
  );
}

async function comparePlans(page: Page, seen: Witness, where: string): Promise<void> {
  const sections = page.getByTestId('plans').locator('section');
  await expect(sections, where).toHaveCount(seen.plans.length);
  const last = seen.plans.at(-1);
  if (last) await expect(sections.first(), where).toContainText(last);
}

async function compareAlarms(page: Page, seen: Witness, where: string): Promise<void> {
  const raised = async () => {
    const words = await page.getByTestId('alarms').locator('[data-alarm] .words').allTextContents();
    const sum = (head: string) =>
      words
        .filter(text => text.startsWith(head))
        .reduce((count, text) => count + Number(/×(\d+)$/.exec(text)?.[1] ?? 1), 0);
    return { failed: sum('failed: '), faults: sum('fault: '), questions: sum('question: ') };
  };
  const open = () => wordsOf(page.getByTestId('open-question'));
  // The failure of the initial task is that of the flight: one failure is one alarm.
  await expect.poll(async () => (await raised()).failed, { message: where }).toBe(seen.failures);
  const { faults, questions } = await raised();
  expect([faults, questions], where).toEqual([seen.faults, seen.asked]);
  const asked = [...seen.questions.values()].map(({ text }) => text);
  await expect.poll(async () => (await open()).length, { message: `questions, ${where}` }).toBe(asked.length);
  for (const text of asked) expect((await open()).join(' '), where).toContain(text);
}

const RECORDS: [string, () => string, number][] = [
  ['western-states', () => flight('western-states'), 22],
  ['structure-watch', () => flight('structure-watch'), 16],
  ['diagnosis', () => flight('diagnosis'), 6],
  ['a failed run', failedRun, 0],
  [
    'a fork',
    () => {
      const from = flight('diagnosis');
      return made('fork.apex', record => [
        'fork',
        from,
        '--at',
        '600',
        '--wind-factor',
        '1.5',
        '--output',
        record,
      ]);
    },
    6,
  ],
];

for (const [name, recordOf, targets] of RECORDS) {
  test(`random instants of ${name} agree with the trace`, async ({ page }) => {
    test.setTimeout(240_000);
    const record = recordOf();
    const lines = traceOf(record);
    const server = await startServer(record);
    const next = numbers(SEED * 7919 + name.length);
    try {
      const { end_ns } = (await (await fetch(`${server.url}/api/mission`)).json()) as { end_ns: number };
      for (let count = 0; count < INSTANTS; count += 1) {
        // The last instant is the end, where a failure shows.
        const atS = count === INSTANTS - 1 ? end_ns / 1e9 : Math.floor(next() * end_ns * 1e-6) / 1000;
        const where = `${name} at ${atS} s, SHERPA_SEED=${SEED}`;
        const seen = witnessAt(lines, atS);
        await page.goto(`${server.url}/?t=${atS}&rows=resources&tab=alarms`);
        await expect(page.locator('[data-task]').first()).toBeVisible();
        await compareTasks(page, seen, where);
        await compareHolders(page, seen, where);
        await compareAlarms(page, seen, where);
        await compareTargets(page, seen, targets, where);
        await page.getByTestId('tab-plans').click();
        await comparePlans(page, seen, where);
      }
    } finally {
      server.stop();
    }
  });
}

/** Mission times at which the scanner is off, drawn from a flight's commands: seconds. */
function instantsWithoutScanning(record: string, count: number): number[] {
  const commands = traceOf(record, 'command').filter(line => /^\(scanner (on|off)\)$/.test(line.form ?? ''));
  const off = commands.flatMap((line, place) =>
    line.form === '(scanner off)' ? [[line.t, commands[place + 1]?.t ?? line.t + 3600] as const] : [],
  );
  const next = numbers(SEED * 6007);
  return Array.from({ length: count }, () => {
    const [from, to] = off[Math.floor(next() * off.length)] ?? [0, 0];
    return Math.floor(from + 1 + next() * (to - from - 2));
  });
}

test('the score so far is that of a flight which ends at the instant', async ({ page }) => {
  test.setTimeout(240_000);
  const record = flight('day-and-night');
  const missions = new URL('../../missions/', import.meta.url).pathname;
  const server = await startServer(record);
  try {
    for (const atS of instantsWithoutScanning(record, 2)) {
      const where = `day-and-night at ${atS} s, SHERPA_SEED=${SEED}`;
      const short = made('short.apex', file => [
        'fly',
        join(missions, 'day-and-night'),
        '--until',
        `${atS}s`,
        '--record',
        file,
        '--no-progress',
      ]);
      const said = execFileSync(apexProgram(), ['score', short]).toString();
      const score = Number(/^Mission score (-?[\d.]+) = /m.exec(said)?.[1]);
      expect(score, where).toBeGreaterThan(0);
      await page.goto(`${server.url}/?t=${atS}`);
      const shown = page.getByTestId('score-so-far');
      await expect(shown, where).toBeVisible();
      const text = (await shown.textContent())?.replaceAll(',', '');
      // The page rounds to whole points, `apex score` to tenths.
      expect(Math.abs(Number(text) - score), `${text} and ${score}, ${where}`).toBeLessThanOrEqual(0.55);
    }
  } finally {
    server.stop();
  }
});
