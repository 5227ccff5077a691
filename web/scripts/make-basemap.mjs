// Makes the offline map from two npm packages: countries of the world, states of the US, as vector tiles, one file for each zoom.
// Written to public/basemap, which is not committed; runs before every build.
// A file: the length of the directory as four bytes, the lowest first; the directory, JSON that maps `zoom/x/y` to the position and
// length of a tile behind the directory; the tiles (Mapbox vector tile 2.1) with the layers `land` and `borders`.

import { mkdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import { GeoJSONVT } from '@maplibre/geojson-vt';
import { fromGeojsonVt } from '@maplibre/vt-pbf';
import { feature, mesh } from 'topojson-client';

const root = new URL('..', import.meta.url);
const folder = new URL('public/basemap/', root);
/** Numeric code of the US, which is left out here: a separate package has its states in more detail. */
const UNITED_STATES = '840';
/** Zooms with tiles, as in src/panels/map/ground.ts. A unit of the largest one is 150 m, more exact than the outlines. */
const [ZOOM_MIN, ZOOM_MAX] = [1, 5];
/** Units of a tile across, and the margin around it, in which lines are cut: 8 pixels. */
const [EXTENT, MARGIN] = [8192, 128];
/** A fifth of a pixel: points that deviate less from a line are left out below the largest zoom. */
const TOLERANCE = 3.2;

function read(name) {
  return JSON.parse(readFileSync(new URL(`node_modules/${name}`, root), 'utf8'));
}

/** The tiles of some geometries, by zoom, column and row. */
function tilesOf(geometries) {
  const features = geometries.map(geometry => ({ type: 'Feature', properties: {}, geometry }));
  return new GeoJSONVT(
    { type: 'FeatureCollection', features },
    { maxZoom: ZOOM_MAX, extent: EXTENT, buffer: MARGIN, tolerance: TOLERANCE },
  );
}

const world = read('world-atlas/countries-50m.json');
const states = read('us-atlas/states-10m.json');
const abroad = feature(world, {
  ...world.objects.countries,
  geometries: world.objects.countries.geometries.filter(country => country.id !== UNITED_STATES),
});
const layers = {
  land: tilesOf([
    ...abroad.features.map(country => country.geometry),
    ...feature(states, states.objects.nation).features.map(nation => nation.geometry),
  ]),
  borders: tilesOf([
    mesh(world, world.objects.countries, (a, b) => a !== b),
    mesh(states, states.objects.states, (a, b) => a !== b),
  ]),
};

// A folder of an earlier build may hold files of another format.
rmSync(folder, { recursive: true, force: true });
mkdirSync(folder, { recursive: true });
for (let zoom = ZOOM_MIN; zoom <= ZOOM_MAX; zoom += 1)
  writeFileSync(new URL(`ground-${zoom}.tiles`, folder), fileOf(zoom));
console.log(`base map written to ${fileURLToPath(folder)}`);

/** The tiles of a zoom with their directory; the open sea has none. */
function fileOf(zoom) {
  const [directory, tiles] = [{}, []];
  let position = 0;
  for (let place = 0; place < 4 ** zoom; place += 1) {
    const [x, y] = [place % 2 ** zoom, Math.floor(place / 2 ** zoom)];
    const drawn = Object.entries(layers)
      .map(([name, layer]) => [name, layer.getTile(zoom, x, y)])
      .filter(([, tile]) => tile?.features.length > 0);
    if (drawn.length === 0) continue;
    const bytes = fromGeojsonVt(Object.fromEntries(drawn), { version: 2, extent: EXTENT });
    directory[`${zoom}/${x}/${y}`] = [position, bytes.length];
    tiles.push(bytes);
    position += bytes.length;
  }
  const head = Buffer.from(JSON.stringify(directory));
  const length = Buffer.alloc(4);
  length.writeUInt32LE(head.length);
  return Buffer.concat([length, head, ...tiles]);
}
