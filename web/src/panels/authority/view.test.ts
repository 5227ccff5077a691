import { describe, expect, it } from 'vitest';
import type { AuthorityState } from '../../record/types';
import { holderText, isOfferedToYou, offerText } from './view';

const FREE: AuthorityState = {
  epoch: 0,
  holder: null,
  silent: false,
  offer: null,
  you: { name: 'van', role: 'operator' },
  yours: false,
  may_take: true,
  stations: [],
};
const HELD: AuthorityState = {
  ...FREE,
  epoch: 1,
  holder: { name: 'tower', role: 'operator' },
  may_take: false,
};

describe('authority', () => {
  it('names the holder', () => {
    expect(holderText(FREE)).toBe('free');
    expect(holderText(HELD)).toBe('tower (operator)');
    expect(holderText({ ...HELD, silent: true })).toBe('tower (operator), silent');
    expect(holderText({ ...HELD, holder: { name: 'x', role: 'pilot-in-command' } })).toBe(
      'x (pilot in command)',
    );
    expect(holderText({ ...HELD, holder: FREE.you, yours: true })).toBe('you');
  });

  it('names the receiver of an offer, and the time left', () => {
    expect(offerText(HELD)).toBe(null);
    const offered = { ...HELD, offer: { to: 'van', left_s: 41.2 } };
    expect(offerText(offered)).toBe('offered to you for 42 s');
    expect(isOfferedToYou(offered)).toBe(true);
    expect(offerText({ ...HELD, offer: { to: 'ship', left_s: 3 } })).toBe('offered to ship for 3 s');
  });
});
