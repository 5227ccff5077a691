import { describe, expect, it } from 'vitest';
import { tileFile, tileIn } from './ground';

/** A file with two tiles. */
function file(): ArrayBuffer {
  const head = new TextEncoder().encode('{"1/0/0":[0,3],"1/1/0":[3,2]}');
  const bytes = new Uint8Array(4 + head.length + 5);
  new DataView(bytes.buffer).setUint32(0, head.length, true);
  bytes.set(head, 4);
  bytes.set([1, 2, 3, 4, 5], 4 + head.length);
  return bytes.buffer;
}

describe('tiles of the base map', () => {
  it('are parts of a file, and the open sea has none', () => {
    const read = tileFile(file());
    expect([...tileIn(read, '1/0/0')]).toEqual([1, 2, 3]);
    expect([...tileIn(read, '1/1/0')]).toEqual([4, 5]);
    expect([...tileIn(read, '1/0/1')]).toEqual([]);
  });

  it('are copies: the map takes the bytes of a tile away, and may request it again', () => {
    const read = tileFile(file());
    tileIn(read, '1/0/0').fill(9);
    expect([...tileIn(read, '1/0/0')]).toEqual([1, 2, 3]);
  });
});
