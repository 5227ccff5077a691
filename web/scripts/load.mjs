// Measures the server on a large record, with ten clients that ask at the same time:
// node scripts/load.mjs APEX RECORD [SECONDS]
// Makes the record first if it does not exist: 100 steps that repeat, a million lives of tasks with three million intervals, 40
// signals at 10 Hz, and a wide event each tenth of a second: 1 GB. Queries are measured twice: while the server reads the log into its
// index, and after that.

import { spawn } from 'node:child_process';
import { createWriteStream, existsSync, mkdtempSync, readFileSync, statSync, writeFileSync } from 'node:fs';
import { Agent, get } from 'node:http';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

const [apex, record, seconds = '20'] = process.argv.slice(2);
if (!apex || !record) {
  console.error('usage: node scripts/load.mjs APEX RECORD [SECONDS]');
  process.exit(2);
}
const [LANES, MISSION_S, CLIENTS] = [100, 10_000, 10];
/** Signals at 10 Hz, and characters of the event that comes with each of their samples: what a camera says of a picture. */
const [SIGNALS, WIDE] = [40, 9_500];
const agent = new Agent({ keepAlive: true, maxSockets: CLIENTS + 16 });
/** The bars of the design: p95 of any query, and of any instant restored, and the first page. */
const [BAR_MS, RESTORED_MS, FIRST_MS] = [100, 200, 2000];

if (!existsSync(record)) await makeRecord();
const begin = performance.now();
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
  agent.destroy();
  server.kill('SIGTERM');
}

async function measure() {
  // From the start of the program, which compares the file with its seal and reads the effects.
  const start = performance.now();
  const { end_ns: end } = await ask('mission');
  const first = performance.now();
  // What the page asks before its first drawing, at the end of the record.
  const at = `at=${end}`;
  const what = [
    `mission?${at}`,
    `targets?${at}`,
    `plan?${at}`,
    `troubles?${at}`, // english: allow
    `questions?${at}`,
    `report?${at}`,
    'surroundings',
    'track',
  ]; // english: allow
  await Promise.all([...what, `tasks?${at}`, `timeline?${at}`, `events?to=${end}`].map(load));
  const [beforeMs, firstMs, againMs] = [start - begin, performance.now() - start, performance.now() - first];
  console.log(`record of ${(statSync(record).size / 1e9).toFixed(2)} GB, ${CLIENTS} clients`);
  console.log(
    `first page ${firstMs.toFixed(0)} ms after the address is printed (bar ${FIRST_MS} ms), ${againMs.toFixed(0)} ms of them after the effects were read; ${(beforeMs + firstMs).toFixed(0)} ms after the start of the program`,
  );
  await measureQueries('while the log is indexed', end);
  await untilIdle();
  await measureQueries('after that', end);
}

async function measureQueries(when, end) {
  const took = new Map();
  const until = performance.now() + Number(seconds) * 1000;
  const one = async () => {
    while (performance.now() < until) {
      const [name, query] = randomQuery(end);
      const begin = performance.now();
      await load(query);
      took.set(name, [...(took.get(name) ?? []), performance.now() - begin]);
    }
  };
  const before = processorMs();
  await Promise.all(Array.from({ length: CLIENTS }, one));
  const count = [...took.values()].flat().length;
  console.log(
    `${when}: ${count} queries, ${((processorMs() - before) / count).toFixed(1)} ms of processor time each`,
  );
  for (const [name, times] of [...took].sort()) {
    times.sort((a, b) => a - b);
    const share = part => times[Math.min(Math.floor(times.length * part), times.length - 1)].toFixed(0);
    const bar = name === 'restored' ? RESTORED_MS : BAR_MS;
    console.log(
      `  ${name}: ${times.length} times, median ${share(0.5)} ms, p95 ${share(0.95)} ms (bar ${bar} ms)`,
    );
  }
}

/** Processor time of the server so far, milliseconds; clock ticks are hundredths of a second. */
function processorMs() {
  const words = readFileSync(`/proc/${server.pid}/stat`, 'utf8').split(') ')[1].split(' ');
  return (Number(words[11]) + Number(words[12])) * 10;
}

/** A text of figures that differs from tick to tick. */
function wideText(tick) {
  const figures = Array.from({ length: WIDE / 10 }, (_, place) =>
    String((tick * 7919 + place * 104_729) % 999_999_937).padStart(9, '0'),
  );
  return figures.join(' ');
}

/** Waits until the server does nothing for two seconds. */
async function untilIdle() {
  for (let before = -1; processorMs() - before > 20; ) {
    before = processorMs();
    await new Promise(resolve => setTimeout(resolve, 2000));
  }
}

function randomQuery(end) {
  const at = Math.floor(Math.random() * end);
  const from = Math.floor(Math.random() * at);
  const window = `from=${from}&to=${Math.max(at, from + 1)}&at=${at}&px=1000`;
  const queries = [
    ['timeline', `timeline?${window}`],
    ['timeline, zoomed', `timeline?from=${Math.max(at - 60e9, 0)}&to=${at}&at=${at}&px=1000`],
    ['signals', `samples?names=(signal-1 aircraft-1),(signal-2 aircraft-1)&${window}`],
    ['events', `events?from=${from}&to=${at}`],
    ['search', `events?to=${at}&find=work ${Math.floor(Math.random() * LANES)}`],
    ['search, nowhere', `events?to=${at}&find=occurs nowhere`],
    ['commands', `command-log?at=${at}`],
    ['questions', `questions?at=${at}`],
    ['plans', `plans?at=${at}`],
    ['tasks', `tasks?at=${at}`],
    ['mission', `mission?at=${at}`],
    ['failures', `troubles?at=${at}`], // english: allow
    ['holdings', `holdings?${window.replace('&px=1000', '')}`],
    ['restored', `monitors?at=${at}`],
  ];
  return queries[Math.floor(Math.random() * queries.length)];
}

/** Asks, and reads the compressed answer to its end. It is not parsed: that is the client's work, and all clients share a thread. */
function load(query) {
  return new Promise((resolve, reject) => {
    const request = get(
      `${url}/api/${encodeURI(query)}`,
      { agent, headers: { 'accept-encoding': 'gzip' } },
      response => {
        response.on('error', reject);
        response.on('end', () =>
          response.statusCode === 200 ? resolve() : reject(new Error(`${query}: ${response.statusCode}`)),
        );
        response.resume();
      },
    );
    request.on('error', reject);
  });
}

async function ask(query) {
  const response = await fetch(`${url}/api/${query}`);
  if (!response.ok) throw new Error(`${query}: ${response.status} ${await response.text()}`);
  return response.json();
}

async function makeRecord() {
  const folder = mkdtempSync(join(tmpdir(), 'apex-load-'));
  const steps = Array.from(
    { length: LANES },
    (_, lane) => `  (step lane-${lane} (work ${lane}) (waitfor (tick ${lane % 10})) (repeating))`,
  );
  const program = join(folder, 'load.pdl');
  const work = '(primitive (index (work ?lane)) (duration 350ms))';
  writeFileSync(
    program,
    `(procedure (index (do-domain))\n${steps.join('\n')}\n  (step finish (terminate) (waitfor (enough))))\n${work}\n`,
  );
  const inputs = join(folder, 'inputs.jsonl');
  const file = createWriteStream(inputs);
  for (let tick = 0; tick < MISSION_S * 10; tick += 1) {
    const t = tick / 10;
    const lines = [`{"t":${t},"event":"(tick ${tick % 10})"}`];
    for (let signal = 0; signal < SIGNALS; signal += 1) {
      const value = (10 * Math.sin(tick * 0.01 * (signal + 1))).toFixed(4);
      lines.push(`{"t":${t},"measurement":"(signal-${signal} aircraft-1)","value":${value}}`);
    }
    lines.push(`{"t":${t},"event":"(picture ${tick} \\"${wideText(tick)}\\")"}`);
    if (!file.write(`${lines.join('\n')}\n`)) await new Promise(resolve => file.once('drain', resolve));
  }
  file.end(`{"t":${MISSION_S + 1},"event":"(enough)"}\n`);
  await new Promise(resolve => file.once('finish', resolve));
  const run = spawn(apex, ['run', program, '--inputs', inputs, '--record', record], { stdio: 'ignore' });
  await new Promise((resolve, reject) =>
    run.on('exit', code => (code === 0 ? resolve() : reject(new Error(`apex run ended with ${code}`)))),
  );
}
