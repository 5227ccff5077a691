/** Tiles of the offline base map: one file for each zoom, read at the first request for a tile of that zoom. */

import * as maplibre from 'maplibre-gl';

/** Zooms with tiles, as in scripts/make-basemap.mjs. Larger zooms enlarge the tiles of the last one. */
const [ZOOM_MIN, ZOOM_MAX] = [1, 5];
const SCHEME = 'ground';

/** A tile file: the position and length of each tile in its bytes. */
export interface TileFile {
  directory: Record<string, [position: number, length: number]>;
  tiles: Uint8Array<ArrayBuffer>;
}

const files = new Map<string, Promise<TileFile>>();

/** The source of the base map, with the layers `land` and `borders`. */
export function groundSource(): maplibre.VectorSourceSpecification {
  maplibre.addProtocol(SCHEME, readTile);
  return { type: 'vector', tiles: [`${SCHEME}://{z}/{x}/{y}`], minzoom: ZOOM_MIN, maxzoom: ZOOM_MAX };
}

async function readTile({ url }: { url: string }): Promise<{ data: Uint8Array }> {
  const [, key = '', zoom = ''] = /^[^:]+:\/\/((\d+)\/\d+\/\d+)$/.exec(url) ?? [];
  const file = files.get(zoom) ?? readFile(zoom);
  files.set(zoom, file);
  try {
    return { data: tileIn(await file, key) };
  } catch (error) {
    // The next request for a tile of this zoom tries again.
    files.delete(zoom);
    throw error;
  }
}

async function readFile(zoom: string): Promise<TileFile> {
  const response = await fetch(`/basemap/ground-${zoom}.tiles`);
  if (!response.ok) throw new Error(`base map of zoom ${zoom}: ${response.status} ${response.statusText}`);
  return tileFile(await response.arrayBuffer());
}

/** Splits the bytes of a file. */
export function tileFile(bytes: ArrayBuffer): TileFile {
  const length = new DataView(bytes).getUint32(0, true);
  const head = new TextDecoder().decode(new Uint8Array(bytes, 4, length));
  return { directory: JSON.parse(head), tiles: new Uint8Array(bytes, 4 + length) };
}

/** A copy of a tile, because the map takes the bytes away; empty for the open sea. */
export function tileIn({ directory, tiles }: TileFile, key: string): Uint8Array {
  const [position, length] = directory[key] ?? [0, 0];
  return tiles.slice(position, position + length);
}
