// Writes each text file of dist as FILE.gz, too: the server sends that to browsers that take it. Runs after every build.

import { readdirSync, readFileSync, writeFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import { constants, gzipSync } from 'node:zlib';

const folder = new URL('../dist/', import.meta.url);
const TEXT = /\.(css|geojson|html|js|mjs|svg)$/;
let [plain, small] = [0, 0];
for (const name of readdirSync(folder, { recursive: true }).filter(name => TEXT.test(name))) {
  const bytes = readFileSync(new URL(name, folder));
  const packed = gzipSync(bytes, { level: constants.Z_BEST_COMPRESSION });
  writeFileSync(new URL(`${name}.gz`, folder), packed);
  [plain, small] = [plain + bytes.length, small + packed.length];
}
console.log(`${fileURLToPath(folder)}: ${plain} bytes of text, ${small} compressed`);
