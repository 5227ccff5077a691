// Permitted imports between folders of web/src. A rule that is written down is a rule that is checked; `npm run check` runs this.

import { readdirSync, readFileSync } from 'node:fs';
import { dirname, join, normalize, relative } from 'node:path';
import { fileURLToPath } from 'node:url';

const source = fileURLToPath(new URL('../src', import.meta.url));

/** Folder -> folders it may import. A panel may import its own folder, and no other panel. */
const ROOMS = {
  time: [],
  files: [],
  theme: [],
  units: [],
  words: [],
  record: ['time'],
  parts: ['theme', 'time'],
  player: ['record', 'time', 'words'],
  panels: ['files', 'parts', 'player', 'record', 'time', 'theme', 'units', 'words'],
  layout: ['panels', 'player', 'record'],
  app: ['layout', 'panels', 'parts', 'player', 'record', 'time', 'theme'],
};
/** Package -> where it may be imported. */
const PACKAGES = {
  svelte: () => true,
  'maplibre-gl': file => file.startsWith('panels/map/'),
  uplot: file => file.startsWith('panels/details/'),
  pmtiles: file => file.startsWith('panels/map/'),
  'hyparquet-writer': file => file.startsWith('files/'),
  hyparquet: file => file.endsWith('.test.ts'),
  vitest: file => file.endsWith('.test.ts'),
};

const files = readdirSync(source, { recursive: true })
  .map(name => name.replaceAll('\\', '/'))
  .filter(name => /\.(ts|svelte)$/.test(name));
const faults = [];
for (const file of files) {
  const text = readFileSync(join(source, file), 'utf8');
  for (const [, name] of text.matchAll(/(?:from|import)\s*\(?\s*['"]([^'"]+)['"]/g)) {
    const fault = name.startsWith('.') ? checkRoom(file, name) : checkPackage(file, name);
    if (fault) faults.push(`src/${file}: ${fault}`);
  }
}
if (faults.length > 0) {
  console.error(`${faults.join('\n')}\nThe rules are in scripts/check-imports.mjs.`);
  process.exit(1);
}
console.log(`imports: ${files.length} files keep the rules`);

function checkPackage(file, name) {
  const scoped = name.startsWith('@') ? 2 : 1;
  const rule = PACKAGES[name.split('/').slice(0, scoped).join('/')];
  if (!rule) return `imports the package ${name}, which is not in the list`;
  return rule(file) ? undefined : `may not import ${name} here`;
}

function checkRoom(file, name) {
  const target = relative(source, normalize(join(source, dirname(file), name))).replaceAll('\\', '/');
  if (target.startsWith('..')) return `imports ${name}, outside of src`;
  const [from, to] = [room(file), room(target)];
  if (from === 'panels' && to === 'panels' && panel(file) !== panel(target)) {
    return `panel ${panel(file)} may not import panel ${panel(target)}`;
  }
  if (/\/view\.ts$/.test(file) && /^panels\/.*\.svelte$/.test(target))
    return 'a view model may not import drawing';
  if (from !== to && !ROOMS[from].includes(to)) return `folder ${from} may not import folder ${to} (${name})`;
  return undefined;
}

function room(file) {
  return file.includes('/') ? file.split('/')[0] : 'app';
}

function panel(file) {
  return file.split('/')[1];
}
