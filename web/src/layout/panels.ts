/** The registry of panels: the name and the component of each. */

import type { Component } from 'svelte';
import Agenda from '../panels/agenda/Agenda.svelte';
import Alarms from '../panels/alarms/Alarms.svelte';
import Compare from '../panels/compare/Compare.svelte';
import Log from '../panels/details/Log.svelte';
import Plans from '../panels/details/Plans.svelte';
import ReportTab from '../panels/details/ReportTab.svelte';
import Signals from '../panels/details/Signals.svelte';
import WhyTab from '../panels/details/WhyTab.svelte';
import Draft from '../panels/draft/Draft.svelte';
import Monitors from '../panels/monitors/Monitors.svelte';
import Network from '../panels/network/Network.svelte';
import Objects from '../panels/objects/Objects.svelte';
import Program from '../panels/program/Program.svelte';
import WhatIf from '../panels/whatif/WhatIf.svelte';
import type { Panel } from '../player/layout';
import type { Operator } from '../player/operator.svelte';
import type { Player } from '../player/player.svelte';
import type { Workshop } from '../record/whatif';

/** The properties that every panel receives. */
export interface PanelProps {
  player: Player;
  operator: Operator;
  workshop: Workshop;
}

export const REGISTRY: Record<Panel, { title: string; component: Component<PanelProps> }> = {
  agenda: { title: 'Agenda', component: Agenda as Component<PanelProps> },
  objects: { title: 'Objects', component: Objects as Component<PanelProps> },
  program: { title: 'PDL', component: Program as Component<PanelProps> },
  network: { title: 'Network', component: Network as Component<PanelProps> },
  draft: { title: 'Draft', component: Draft as Component<PanelProps> },
  why: { title: 'Why', component: WhyTab as Component<PanelProps> },
  monitors: { title: 'Monitors', component: Monitors as Component<PanelProps> },
  signals: { title: 'Signals', component: Signals as Component<PanelProps> },
  plans: { title: 'Plans', component: Plans as Component<PanelProps> },
  log: { title: 'Trace', component: Log as Component<PanelProps> },
  alarms: { title: 'Alarms', component: Alarms as Component<PanelProps> },
  whatif: { title: 'What if', component: WhatIf as Component<PanelProps> },
  compare: { title: 'Compare', component: Compare as Component<PanelProps> },
  report: { title: 'Report', component: ReportTab as Component<PanelProps> },
};
