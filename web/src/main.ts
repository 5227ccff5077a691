/** Starts the page: one record (that of the server the page came from), one Player, one App. */

import { mount } from 'svelte';
import App from './App.svelte';
import Paper from './panels/report/Paper.svelte';
import { readAddress } from './player/address';
import { Operator } from './player/operator.svelte';
import { Player } from './player/player.svelte';
import { ServedFlight } from './record/operation';
import { ServedRecord } from './record/source';
import { Workshop } from './record/whatif';
import { applyColours } from './theme/colours';
import './theme/theme.css';

const { address, faults } = readAddress(window.location.search);
applyColours(document.documentElement, address.theme ?? 'dark');
// Canvases do not redraw when a font arrives: wait for the two, which come from this server. Without them it goes too.
await Promise.allSettled([
  document.fonts.load('600 11px Inter'),
  document.fonts.load('11px "JetBrains Mono"'),
]);
const target = document.getElementById('app');
if (!target) throw new Error('index.html has no element #app');
const source = new ServedRecord(window.location.origin, address.record ?? 0);
if (new URLSearchParams(window.location.search).get('print') === '1') {
  applyColours(document.documentElement, 'light');
  document.documentElement.dataset.paper = '';
  mount(Paper, { target, props: { source, atNs: typeof address.atNs === 'number' ? address.atNs : null } });
} else {
  start(target);
}

function start(target: HTMLElement): void {
  const player = new Player(source);
  const operator = new Operator(new ServedFlight(window.location.origin));
  const workshop = new Workshop(window.location.origin);
  mount(App, { target, props: { player, operator, workshop, theme: address.theme, faults } });
  void player.open(address);
  void operator.watch();
}
