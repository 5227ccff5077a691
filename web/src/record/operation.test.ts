import { afterEach, expect, it, vi } from 'vitest';
import { ServedFlight } from './operation';

const answer = (status: number, body: unknown) =>
  vi.stubGlobal('fetch', async () => new Response(JSON.stringify(body), { status }));
afterEach(() => vi.unstubAllGlobals());

it('takes null for a server without a flight under way', async () => {
  answer(200, null);
  expect(await new ServedFlight('').operation()).toBeNull();
});

it('does not name addresses of the server in its help', async () => {
  answer(403, {
    error: 'this needs operator',
    help: 'begin a session with another token: POST /api/session',
    remedy: 'role',
  });
  const refused = new ServedFlight('').command({ do: 'pause' }, null);
  await expect(refused).rejects.toMatchObject({
    message: 'this needs operator',
    help: expect.not.stringContaining('/api/'),
  });
});
