/** Starts the page with the record of the server that sent it: one Player, one App. */

import { mount } from 'svelte';
import App from './App.svelte';
import SignIn from './panels/authority/SignIn.svelte';
import Paper from './panels/report/Paper.svelte';
import { readAddress } from './player/address';
import { Operator } from './player/operator.svelte';
import { Player } from './player/player.svelte';
import { ServedFlight } from './record/operation';
import { beginSession, currentSession, tokenIn } from './record/session';
import { ServedRecord } from './record/source';
import { Workshop } from './record/whatif';
import { applyColours } from './theme/colours';
import './theme/theme.css';

const { address, faults } = readAddress(window.location.search);
applyColours(document.documentElement, address.theme ?? 'dark');
// Canvases do not redraw when a font arrives, so wait for both fonts of this server. If they fail to load, the page starts without them.
await Promise.allSettled([
  document.fonts.load('600 11px Inter'),
  document.fonts.load('11px "JetBrains Mono"'),
]);
const target = document.getElementById('app');
if (!target) throw new Error('index.html has no element #app');
const base = window.location.origin;
const source = new ServedRecord(base, address.record ?? 0);
const token = tokenIn(window.location.hash);
let fault: string | null = null;
if (token !== null) {
  // Remove the token from the address, so that the browser's history does not keep it.
  window.history.replaceState(null, '', window.location.pathname + window.location.search);
  await beginSession(base, { token }).catch(error => {
    fault = String(error.message);
  });
}
// If the server does not answer, the page reports that there is no connection.
const session = await currentSession(base).catch(() => undefined);
if (session === null) {
  mount(SignIn, { target, props: { base, fault, ondone: () => window.location.reload() } });
} else if (new URLSearchParams(window.location.search).get('print') === '1') {
  applyColours(document.documentElement, 'light');
  document.documentElement.dataset.paper = '';
  mount(Paper, { target, props: { source, atNs: typeof address.atNs === 'number' ? address.atNs : null } });
} else {
  start(target);
}

function start(target: HTMLElement): void {
  const player = new Player(source);
  const operator = new Operator(new ServedFlight(base));
  const workshop = new Workshop(base);
  mount(App, { target, props: { player, operator, workshop, theme: address.theme, faults } });
  void player.open(address);
  void operator.watch();
}
