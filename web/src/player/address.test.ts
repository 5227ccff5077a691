import { describe, expect, it } from 'vitest';
import { readAddress, writeAddress } from './address';

const nothing = {
  atNs: null,
  window: null,
  selection: null,
  theme: null,
  strips: null,
  span: null,
  tab: null,
  left: null,
  layout: null,
  record: null,
  versus: null,
  rows: null,
};

describe('the address', () => {
  it('is read back as it was written', () => {
    const state = {
      atNs: 33_432_500_000_000,
      window: { fromNs: 32_100e9, toNs: 33_900e9 },
      selection: { target: 'castle-rock' },
      theme: 'light' as const,
      strips: ['roll-angle aircraft-1', 'fuel aircraft-1'],
      span: { fromNs: 32_200e9, toNs: 32_300e9 },
      tab: 'signals' as const,
      left: 'objects' as const,
      layout: null,
      record: 2,
      versus: 3,
      rows: 'targets' as const,
    };
    const text = writeAddress('', state);
    expect(text).toBe(
      '?t=33432.5&w=32100-33900&sel=target:castle-rock&tab=signals&left=objects&rec=2&vs=3&rows=targets&strips=roll-angle+aircraft-1,fuel+aircraft-1&range=32200-32300&theme=light',
    );
    expect(readAddress(text)).toEqual({ address: state, faults: [] });
    expect(readAddress('?t=live&sel=task:341').address).toEqual({
      ...nothing,
      atNs: 'live',
      selection: { task: 341 },
    });
  });

  it('selects an event or a plan by its number', () => {
    for (const selection of [{ event: 1234 }, { plan: 2 }]) {
      const [[kind, number] = []] = Object.entries(selection);
      const text = writeAddress('', { ...nothing, selection });
      expect(text).toBe(`?sel=${kind}:${number}`);
      expect(readAddress(text)).toEqual({ address: { ...nothing, selection }, faults: [] });
    }
    for (const wrong of ['event:first', 'plan:-1', 'event:', 'plan:99999999999999999999', 'pilot:1'])
      expect(readAddress(`?sel=${wrong}`)).toEqual({
        address: nothing,
        faults: [
          `The address has sel=${wrong}; expected task:NUMBER, target:NAME, event:NUMBER or plan:NUMBER.`,
        ],
      });
  });

  it('leaves defaults out and keeps what it does not know', () => {
    expect(writeAddress('?t=5&colour=blue', nothing)).toBe('?colour=blue');
    expect(writeAddress('', nothing)).toBe('');
  });

  it('names what is wrong and uses the rest', () => {
    const { address, faults } = readAddress('?t=noon&w=9-3&sel=task:12');
    expect(address).toEqual({ ...nothing, selection: { task: 12 } });
    expect(faults).toEqual([
      'The address has t=noon; expected seconds of mission time, or live.',
      'The address has w=9-3; expected two times in seconds, 3600-7200.',
    ]);
  });
});
