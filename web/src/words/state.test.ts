import { describe, expect, it } from 'vitest';
import { stateSign } from './state';

describe('the sign of a state', () => {
  it('differs for each state and outcome', () => {
    const ended = ['success', 'failure', 'cut'].map(outcome => stateSign({ state: 'terminated', outcome }));
    const living = ['pending', 'enabled', 'ongoing', 'interrupted'].map(state =>
      stateSign({ state, outcome: null }),
    );
    const signs = [
      ...living,
      ...ended,
      stateSign({ state: 'ongoing', outcome: null }, true),
      stateSign(undefined),
    ];
    const others = ['precondition failed', 'invariant violated', 'skipped', 'exited'];
    expect(others.map(outcome => stateSign({ state: 'terminated', outcome }))).toEqual(['▲', '▲', '–', '–']);
    expect(signs).toEqual(['○', '◇', '●', '▨', '✓', '▲', '–', '◐', '·']);
  });
});
