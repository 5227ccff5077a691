// Makes the offline map from two npm packages: countries of the world, states of the US, as GeoJSON.
// Written to public/basemap, which is not committed; runs before every build.

import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import { feature, mesh } from 'topojson-client';

const root = new URL('..', import.meta.url);
const folder = new URL('public/basemap/', root);
/** Numeric code of the US, which is left out here: a separate package has its states in more detail. */
const UNITED_STATES = '840';
/** Decimals of coordinates: about 100 m on the ground, which is more exact than the outlines. */
const DECIMALS = 3;

function read(name) {
  return JSON.parse(readFileSync(new URL(`node_modules/${name}`, root), 'utf8'));
}

function rounded(value) {
  if (typeof value === 'number') return Number(value.toFixed(DECIMALS));
  return Array.isArray(value) ? value.map(rounded) : value;
}

function write(name, geometries) {
  const features = geometries.map(geometry => ({
    type: 'Feature',
    properties: {},
    geometry: { type: geometry.type, coordinates: rounded(geometry.coordinates) },
  }));
  writeFileSync(new URL(name, folder), JSON.stringify({ type: 'FeatureCollection', features }));
}

const world = read('world-atlas/countries-50m.json');
const states = read('us-atlas/states-10m.json');
const abroad = feature(world, {
  ...world.objects.countries,
  geometries: world.objects.countries.geometries.filter(country => country.id !== UNITED_STATES),
});

mkdirSync(folder, { recursive: true });
write('land.geojson', [
  ...abroad.features.map(country => country.geometry),
  ...feature(states, states.objects.nation).features.map(nation => nation.geometry),
]);
write('borders.geojson', [
  mesh(world, world.objects.countries, (a, b) => a !== b),
  mesh(states, states.objects.states, (a, b) => a !== b),
]);
console.log(`base map written to ${fileURLToPath(folder)}`);
