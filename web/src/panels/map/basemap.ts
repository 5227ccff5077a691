/** Base map below the flight: outlines of land and borders from local tiles; no glyphs, no other server. */

import * as maplibre from 'maplibre-gl';
import 'maplibre-gl/dist/maplibre-gl.css';
import workerUrl from 'maplibre-gl/dist/maplibre-gl-worker.mjs?worker&url';
import { COLOURS } from '../../theme/colours';
import { groundSource } from './ground';

// Vite moves the worker file of MapLibre; without the new URL the map stays blank.
maplibre.setWorkerUrl(workerUrl);

const land = { source: 'ground', 'source-layer': 'land' };

/** The style in the colours of the theme in use. */
const style = (): maplibre.StyleSpecification => ({
  version: 8,
  sources: { ground: groundSource() },
  layers: [
    { id: 'sea', type: 'background', paint: { 'background-color': COLOURS.sea } },
    { ...land, id: 'land', type: 'fill', paint: { 'fill-color': COLOURS.land } },
    // The outlines of the US and of other countries come from two atlases: a line in the land's colour closes gaps between them.
    { ...land, id: 'seam', type: 'line', paint: { 'line-color': COLOURS.land, 'line-width': 3 } },
    { ...land, id: 'coast', type: 'line', paint: { 'line-color': COLOURS.coast, 'line-width': 0.8 } },
    {
      id: 'borders',
      type: 'line',
      source: 'ground',
      'source-layer': 'borders',
      paint: { 'line-color': COLOURS.border, 'line-width': 1 },
    },
  ],
});

/** Makes the map in `container`; throws when the browser has no WebGL. */
export function makeMap(container: HTMLElement): maplibre.Map {
  const map = new maplibre.Map({
    container,
    style: style(),
    center: [-117, 41],
    zoom: 4,
    minZoom: 1.5,
    maxZoom: 18,
    attributionControl: false,
    dragRotate: false,
    pitchWithRotate: false,
    touchPitch: false,
    keyboard: false,
    // The panel watches its size: a second watcher would draw the map twice.
    trackResize: false,
    fadeDuration: 0,
    // A flight across the 180th meridian needs the ground on both sides of it.
    renderWorldCopies: true,
  });
  map.touchZoomRotate.disableRotation();
  map.addControl(new maplibre.ScaleControl({ maxWidth: 110, unit: 'nautical' }), 'bottom-right');
  return map;
}
