import { describe, expect, it } from 'vitest';
import { sticks } from '../src/pages/move/sticks';

const buttons = (held: number[]) => Array.from({ length: 16 }, (_, i) => ({ pressed: held.includes(i), value: held.includes(i) ? 1 : 0 }));

describe('a gamepad', () => {
  it('moves nothing while the button that allows it is up', () => {
    expect(sticks({ axes: [1, 1, 1, 1], buttons: buttons([]) })).toBeNull();
  });
  it('does not drift while the sticks are at rest', () => {
    expect(sticks({ axes: [0.1, -0.15, 0.12, 0.05], buttons: buttons([5]) })).toEqual([0, 0, 0, 0, 0, 0]);
  });
  it('moves forwards and to the left with the left stick, up and down with the triggers', () => {
    expect(sticks({ axes: [-1, -1, 0, 0], buttons: buttons([5, 7]) })).toEqual([1, 1, 1, 0, 0, 0]);
    expect(sticks({ axes: [0, 0, 0, 0], buttons: buttons([5, 6]) })).toEqual([0, 0, -1, 0, 0, 0]);
  });
  it('never asks for more than the whole speed', () => {
    for (const value of sticks({ axes: [-1.02, 1.02, -1.02, 1.02], buttons: buttons([5]) })!) expect(Math.abs(value)).toBeLessThanOrEqual(1);
  });
});
