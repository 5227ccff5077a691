/** Tiles added by the user: a PMTiles file that stays in the browser, drawn by the base map below all layers of the flight. */

import * as maplibre from 'maplibre-gl';
import type { Header, PMTiles, Source } from 'pmtiles';
import { COLOURS } from '../../theme/colours';

/** A layer of tiles on the map. */
export interface TileLayer {
  name: string;
  remove(): void;
}

/** The numbers of tile types in the format (PMTiles version 3, section 3.11). */
const VECTOR = 1;
const RASTERS = [2, 3, 4, 5];
const SCHEME = 'user-tiles';

const archives = new Map<string, PMTiles>();
let made = 0;

/** Draws the file on the map, or returns its problem in one sentence. */
export async function addTiles(map: maplibre.Map, file: File): Promise<TileLayer | string> {
  const { PMTiles } = await import('pmtiles');
  const key = `user-${++made}`;
  const archive = new PMTiles(sourceOf(key, file));
  let header: Header;
  let names: string[];
  try {
    header = await archive.getHeader();
    names = header.tileType === VECTOR ? layerNames(await archive.getMetadata()) : [];
  } catch (error) {
    return `${file.name} is not a PMTiles file: ${error instanceof Error ? error.message : error}`;
  }
  const isRaster = RASTERS.includes(header.tileType);
  if (!isRaster && header.tileType !== VECTOR)
    return `${file.name} has tiles of type ${header.tileType}; expected vector tiles (MVT), PNG, JPEG, WebP or AVIF`;
  if (!isRaster && names.length === 0)
    return `${file.name} does not name its layers: its metadata have no \`vector_layers\``;
  if (archives.size === 0) maplibre.addProtocol(SCHEME, readTile);
  archives.set(key, archive);
  map.addSource(key, {
    type: isRaster ? 'raster' : 'vector',
    tiles: [`${SCHEME}://${key}/{z}/{x}/{y}`],
    minzoom: header.minZoom,
    maxzoom: header.maxZoom,
    ...(isRaster ? { tileSize: 256 } : {}),
  } as maplibre.SourceSpecification);
  const layers = isRaster ? [rasterLayer(key)] : names.flatMap(name => vectorLayers(key, name));
  for (const layer of layers) map.addLayer(layer);
  return {
    name: file.name,
    remove: () => {
      for (const layer of layers) map.removeLayer(layer.id);
      map.removeSource(key);
      archives.delete(key);
    },
  };
}

/** Reads pieces of the file; nothing is sent anywhere. */
function sourceOf(key: string, file: File): Source {
  return {
    getKey: () => key,
    getBytes: async (offset, length) => ({ data: await file.slice(offset, offset + length).arrayBuffer() }),
  };
}

/** The names of the layers of vector tiles, of their metadata. */
export function layerNames(metadata: unknown): string[] {
  const { vector_layers: layers } = (metadata ?? {}) as { vector_layers?: unknown };
  if (!Array.isArray(layers)) return [];
  return layers.flatMap(layer => (typeof layer?.id === 'string' ? [layer.id] : []));
}

/** The answer to the base map's question for a tile; a tile that the file does not have is empty. */
async function readTile({ url }: { url: string }): Promise<{ data: Uint8Array }> {
  const [, key = '', z, x, y] = /^[^:]+:\/\/([^/]+)\/(\d+)\/(\d+)\/(\d+)$/.exec(url) ?? [];
  const tile = await archives.get(key)?.getZxy(Number(z), Number(x), Number(y));
  return { data: tile ? new Uint8Array(tile.data) : new Uint8Array() };
}

function rasterLayer(key: string): maplibre.LayerSpecification {
  return { id: key, type: 'raster', source: key, paint: { 'raster-opacity': 0.7 } };
}

/** Areas, lines and points of one layer, all in the colour of the user's layers. */
function vectorLayers(key: string, name: string): maplibre.LayerSpecification[] {
  const of = { source: key, 'source-layer': name };
  const only = (...kinds: string[]) => ['in', ['geometry-type'], ['literal', kinds]];
  const colour = COLOURS.user;
  return [
    {
      ...of,
      id: `${key} ${name} areas`,
      type: 'fill',
      filter: only('Polygon', 'MultiPolygon'),
      paint: { 'fill-color': colour, 'fill-opacity': 0.2 },
    },
    {
      ...of,
      id: `${key} ${name} lines`,
      type: 'line',
      filter: only('LineString', 'MultiLineString', 'Polygon', 'MultiPolygon'),
      paint: { 'line-color': colour, 'line-width': 2 },
    },
    {
      ...of,
      id: `${key} ${name} points`,
      type: 'circle',
      filter: only('Point', 'MultiPoint'),
      paint: { 'circle-color': colour, 'circle-radius': 2.5 },
    },
  ] as maplibre.LayerSpecification[];
}
