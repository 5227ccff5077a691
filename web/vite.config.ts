import { svelte } from '@sveltejs/vite-plugin-svelte';
import { defineConfig } from 'vitest/config';

/** The server from which `npm run dev` gets data: `apex serve FILE.apex`. */
const api = process.env.APEX_URL ?? 'http://127.0.0.1:8040';

export default defineConfig({
  plugins: [svelte()],
  build: { target: 'es2022', chunkSizeWarningLimit: 1500 },
  worker: { format: 'es' },
  server: { proxy: { '/api': { target: api, changeOrigin: true, ws: true } } },
  test: { include: ['src/**/*.test.ts'], environment: 'node' },
});
