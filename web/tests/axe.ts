/** Checks the page's accessibility with axe-core. */

import { readFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import { expect, type Page } from '@playwright/test';

/** The source of the checker. */
const AXE = readFileSync(fileURLToPath(import.meta.resolve('axe-core/axe.min.js')), 'utf8');

/** The part of the checker that is used. */
interface Axe {
  configure(options: { noHtml: boolean }): void;
  run(options: { resultTypes: string[]; elementRef: boolean }): Promise<{
    violations: { id: string; nodes: { element?: Element }[] }[];
  }>;
}

/** Fails if axe finds a fault in the present state of the page, which `state` names. */
export async function expectNoFaults(page: Page, state: string): Promise<void> {
  // The server's content rules keep other scripts out of the page, so this script is injected by the debugger.
  if (!(await page.evaluate(() => 'axe' in window))) await page.evaluate(AXE);
  const faults = await page.evaluate(async () => {
    const { axe } = window as unknown as { axe: Axe };
    // Of elements without faults nothing is reported, and their HTML would take a fifth of the time.
    axe.configure({ noHtml: true });
    const { violations } = await axe.run({ resultTypes: ['violations'], elementRef: true });
    return violations.flatMap(({ id, nodes }) =>
      nodes.map(node => `${id}: ${node.element?.outerHTML.slice(0, 160)}`),
    );
  });
  expect(faults, state).toEqual([]);
}
