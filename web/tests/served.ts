/**
 * Serves the record of the environment, and that of structure-watch next to it, once for all files of tests, which only read them: the
 * server computes the ground seen and the score of a flight at their first request.
 */

import { existsSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { type Server, startServer } from './server';

/** Returns the function that ends the servers. */
export default async function serveOnce(): Promise<() => void> {
  const { APEX_URL, APEX_RECORD } = process.env;
  if (APEX_URL || !APEX_RECORD) return () => undefined;
  const records = [APEX_RECORD, join(dirname(APEX_RECORD), 'structure-watch.apex')];
  const servers: Record<string, Server> = {};
  for (const record of records) if (existsSync(record)) servers[record] ??= await startServer(record);
  const urls = Object.entries(servers).map(([record, { url }]) => [record, url]);
  process.env.APEX_SERVED = JSON.stringify(Object.fromEntries(urls));
  return () => {
    for (const server of Object.values(servers)) server.stop();
  };
}
