// Writes each text file of dist and the base map as FILE.gz, too: the server sends that to browsers that take it. Runs after every build.

import { readdirSync, readFileSync, writeFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import { constants, gzipSync } from 'node:zlib';

const folder = new URL('../dist/', import.meta.url);
const LARGE = /\.(css|html|js|mjs|svg|tiles)$/;
let [plain, small] = [0, 0];
for (const name of readdirSync(folder, { recursive: true }).filter(name => LARGE.test(name))) {
  const bytes = readFileSync(new URL(name, folder));
  const packed = gzipSync(bytes, { level: constants.Z_BEST_COMPRESSION });
  writeFileSync(new URL(`${name}.gz`, folder), packed);
  [plain, small] = [plain + bytes.length, small + packed.length];
}
console.log(`${fileURLToPath(folder)}: ${plain} bytes of text and base map, ${small} compressed`);
