/** Starts the page: one record (that of the server the page came from), one Player, one App. */

import { mount } from 'svelte';
import App from './App.svelte';
import { readAddress } from './player/address';
import { Operator } from './player/operator.svelte';
import { Player } from './player/player.svelte';
import { ServedFlight } from './record/operation';
import { ServedRecord } from './record/source';
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
const player = new Player(new ServedRecord(window.location.origin));
const operator = new Operator(new ServedFlight(window.location.origin));
mount(App, { target, props: { player, operator, theme: address.theme, faults } });
void player.open(address);
void operator.watch();
