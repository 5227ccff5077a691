import { defineConfig } from '@playwright/test';
import { launchOptions, viewport } from './tests/browser.mjs';

export default defineConfig({
  testDir: 'tests',
  testMatch: '**/*.spec.ts',
  outputDir: 'test-results',
  // The files run two at a time; a test mostly waits for the browser to draw or for the server to answer.
  workers: 2,
  timeout: 120_000,
  expect: { timeout: 15_000 },
  reporter: [['list']],
  use: { viewport, screenshot: 'only-on-failure', launchOptions },
});
