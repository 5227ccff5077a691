import { expect, it } from 'vitest';
import { actionFor } from './view';

const press = (key: string, more = {}) => ({
  key,
  shiftKey: false,
  ctrlKey: false,
  metaKey: false,
  altKey: false,
  ...more,
});

it('leaves keys to a field that is typed in, and to the browser', () => {
  expect(actionFor(press('f'), false)).toBe('fit');
  expect(actionFor(press('f'), true)).toBeUndefined();
  expect(actionFor(press('f', { ctrlKey: true }), false)).toBeUndefined();
  expect(actionFor(press('Escape'), true)).toBe('close');
  expect(actionFor(press('q'), false)).toBeUndefined();
});
