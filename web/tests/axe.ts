/** Checks the page's accessibility with axe-core. */

import { readFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import { expect, type Page } from '@playwright/test';

/** The source of the checker. */
const AXE = readFileSync(fileURLToPath(import.meta.resolve('axe-core/axe.min.js')), 'utf8');

/** Fails if axe finds a fault in the present state of the page, which `state` names. */
export async function expectNoFaults(page: Page, state: string): Promise<void> {
  // The server's content rules keep other scripts out of the page, so this script is injected by the debugger.
  await page.evaluate(AXE);
  const faults = await page.evaluate(async () => {
    const { axe } = window as unknown as {
      axe: { run(): Promise<{ violations: { id: string; nodes: { html: string }[] }[] }> };
    };
    const { violations } = await axe.run();
    return violations.flatMap(({ id, nodes }) => nodes.map(node => `${id}: ${node.html.slice(0, 160)}`));
  });
  expect(faults, state).toEqual([]);
}
