import { defineConfig } from '@playwright/test';
import { launchOptions, viewport } from './tests/browser.mjs';

export default defineConfig({
  testDir: 'tests',
  testMatch: '**/*.spec.ts',
  outputDir: 'test-results',
  globalSetup: './tests/served.ts',
  // Tests run two at a time. Those of one file may, too, so that no long file is left at the end; files with a flight of their tests may not.
  workers: 2,
  fullyParallel: true,
  timeout: 120_000,
  expect: { timeout: 15_000 },
  reporter: [['list']],
  use: { viewport, screenshot: 'only-on-failure', launchOptions },
});
