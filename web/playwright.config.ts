import { defineConfig } from '@playwright/test';
import { launchOptions, viewport } from './tests/browser.mjs';

export default defineConfig({
  testDir: 'tests',
  testMatch: '**/*.spec.ts',
  outputDir: 'test-results',
  workers: 1,
  timeout: 60_000,
  expect: { timeout: 15_000 },
  reporter: [['list']],
  use: { viewport, screenshot: 'only-on-failure', launchOptions },
});
