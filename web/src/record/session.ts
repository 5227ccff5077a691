/** The session of this browser with the server. If the server requires tokens, a token begins the session. */

import { RecordError } from './source';
import type { SessionState } from './types';

/** The token in the fragment of an address, which browsers do not send: `#token=..`. */
export function tokenIn(fragment: string): string | null {
  return new URLSearchParams(fragment.replace(/^#/, '')).get('token');
}

/** The session of this browser; null if the server requires a token first. */
export async function currentSession(base: string): Promise<SessionState | null> {
  const response = await fetch(`${base}/api/session`);
  return response.status === 401 ? null : answer(response);
}

/** Begins a session by a token, or by a name where no tokens are needed. */
export async function beginSession(
  base: string,
  by: { token: string } | { name: string },
): Promise<SessionState> {
  const response = await fetch(`${base}/api/session`, {
    method: 'POST',
    headers: { 'Content-Type': 'application/json' },
    body: JSON.stringify(by),
  });
  return answer(response);
}

async function answer(response: Response): Promise<SessionState> {
  const body = await response.json();
  if (!response.ok) throw RecordError.of(response, body);
  return body;
}
