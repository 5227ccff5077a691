/** A small PMTiles file (version 3): one vector tile of the whole world with one area, south of 41.5 degrees north. */

const EXTENT = 4096;

/** Bytes of a whole number, seven bits in each, the lowest first. */
function varint(value: number): number[] {
  const bytes: number[] = [];
  let rest = value;
  for (; rest > 127; rest = Math.floor(rest / 128)) bytes.push((rest % 128) + 128);
  return [...bytes, rest];
}

/** A field of a protocol buffer with content of a length. */
function field(number: number, content: readonly number[]): number[] {
  return [...varint(number * 8 + 2), ...varint(content.length), ...content];
}

function whole(number: number, value: number): number[] {
  return [...varint(number * 8), ...varint(value)];
}

const words = (text: string) => [...Buffer.from(text)];
const zigzag = (value: number) => (value < 0 ? -2 * value - 1 : 2 * value);

/** A vector tile (Mapbox vector tile 2.1) with one polygon of layer `areas`. */
function tile(): number[] {
  // In the projection of the tiles 41.5 degrees north are 0.3737 of the height.
  const top = Math.round(0.3737 * EXTENT);
  const steps = [
    [0, top],
    [EXTENT, 0],
    [0, EXTENT - top],
    [-EXTENT, 0],
  ].map(step => step.flatMap(value => varint(zigzag(value))));
  const [begin = [], ...lines] = steps;
  // Commands: move to one point, line to three, close.
  const geometry = [...varint(9), ...begin, ...varint(26), ...lines.flat(), ...varint(15)];
  const feature = [...whole(3, 3), ...field(4, geometry)];
  return field(3, [...whole(15, 2), ...field(1, words('areas')), ...field(2, feature), ...whole(5, EXTENT)]);
}

/** The file. */
export function tilesOfOneArea(): Buffer {
  const content = tile();
  // One entry: tile 0, one run, its length, and its position 0, stored as 1.
  const directory = [1, 0, 1, content.length, 1].flatMap(varint);
  const metadata = words(JSON.stringify({ vector_layers: [{ id: 'areas', fields: {} }] }));
  const header = Buffer.alloc(127);
  header.write('PMTiles');
  header.writeUInt8(3, 7);
  const begin = header.length;
  const places = [
    [begin, directory.length],
    [begin + directory.length, metadata.length],
    [begin + directory.length + metadata.length, 0],
    [begin + directory.length + metadata.length, content.length],
  ];
  for (const [index, value] of places.flat().entries()) header.writeBigUInt64LE(BigInt(value), 8 + 8 * index);
  for (const at of [72, 80, 88]) header.writeBigUInt64LE(1n, at);
  // Clustered; neither directories nor tiles are compressed; vector tiles; zoom 0 to 0.
  for (const [at, value] of [1, 1, 1, 1, 0, 0].entries()) header.writeUInt8(value, 96 + at);
  for (const [at, value] of [-180e7, -85e7, 180e7, 85e7].entries()) header.writeInt32LE(value, 102 + 4 * at);
  return Buffer.concat([header, Buffer.from([...directory, ...metadata, ...content])]);
}
