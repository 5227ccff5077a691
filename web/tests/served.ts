/**
 * Serves the record of the environment once for all files of tests, which only read it: the server computes the ground seen and the score
 * of a flight at their first request.
 */

import { startServer } from './server';

/** Returns the function that ends the server. */
export default async function serveOnce(): Promise<() => void> {
  const { APEX_URL, APEX_RECORD } = process.env;
  if (APEX_URL || !APEX_RECORD) return () => undefined;
  const server = await startServer();
  process.env.APEX_URL = server.url;
  return () => server.stop();
}
