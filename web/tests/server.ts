/**
 * Servers for the page tests: APEX_URL if one is running, or one of served.ts that serves the record; otherwise `APEX_BIN serve APEX_RECORD`
 * on a free port. APEX_BIN defaults to the release build of this repository.
 */

import { type ChildProcess, spawn } from 'node:child_process';
import { fileURLToPath } from 'node:url';

const START_MS = 20_000;
const DEFAULT_BIN = fileURLToPath(new URL('../../target/release/apex', import.meta.url));

export interface Server {
  url: string;
  stop(): void;
}

/** The `apex` program of the tests. */
export function apexProgram(): string {
  const { APEX_BIN, APEX_BINARY } = process.env;
  return APEX_BIN ?? APEX_BINARY ?? DEFAULT_BIN;
}

/** Serves the record of the environment, or `record`. */
export async function startServer(record?: string): Promise<Server> {
  const { APEX_URL, APEX_RECORD, APEX_SERVED = '{}' } = process.env;
  const served = record ?? APEX_RECORD;
  const common = (JSON.parse(APEX_SERVED) as Record<string, string>)[served ?? ''];
  const url = record ? common : (APEX_URL ?? common);
  if (url) return { url: url.replace(/\/$/, ''), stop: () => undefined };
  if (!served) {
    throw new Error('APEX_RECORD must name a flight record; `apex fly missions/first-picture` writes one');
  }
  const child = spawn(apexProgram(), ['serve', served, '--port', '0'], { stdio: ['ignore', 'pipe', 'pipe'] });
  try {
    return { url: await addressOf(child), stop: () => child.kill('SIGTERM') };
  } catch (error) {
    child.kill('SIGKILL');
    throw error;
  }
}

/** The address that the server prints once it answers. */
export function addressOf(child: ChildProcess): Promise<string> {
  return new Promise((resolve, reject) => {
    let said = '';
    const fail = (why: string) => reject(new Error(`the server did not start: ${why}\n${said}`));
    const timer = setTimeout(() => fail(`nothing after ${START_MS / 1000} s`), START_MS);
    const hear = (data: Buffer) => {
      said += data.toString();
      const address = /https?:\/\/[^\s/]+/.exec(said);
      if (!address) return;
      clearTimeout(timer);
      resolve(address[0]);
    };
    child.stdout?.on('data', hear);
    child.stderr?.on('data', hear);
    child.on('error', error => fail(error.message));
    child.on('exit', code => fail(`it ended with ${code}`));
  });
}
