import { defineConfig } from '@playwright/test';
import { launchOptions, viewport } from './tests/browser.mjs';

export default defineConfig({
  testDir: 'tests',
  testMatch: '**/*.spec.ts',
  outputDir: 'test-results',
  globalSetup: './tests/served.ts',
  // Tests run two at a time. Tests of one file may run in parallel, too, so that no long file is left at the end, except in files whose tests share a flight.
  workers: 2,
  fullyParallel: true,
  timeout: 120_000,
  expect: { timeout: 15_000 },
  reporter: [['list']],
  use: { viewport, screenshot: 'only-on-failure', launchOptions },
});
