import { describe, expect, it } from 'vitest';
import { leastSpan, padded } from '../src/pages/plots/span';

describe('the y axis of a plot', () => {
  it('does not blow up noise', () => {
    const [low, high] = padded(45.0001, 45.0003, leastSpan('°'));
    expect(high - low).toBeGreaterThanOrEqual(1);
    expect((low + high) / 2).toBeCloseTo(45.0002);
  });
  it('shows all of what moves', () => {
    const [low, high] = padded(-90, 90, leastSpan('°'));
    expect(low).toBeLessThan(-90);
    expect(high).toBeGreaterThan(90);
    expect(high - low).toBeLessThan(220);
  });
  it('has a span where nothing was measured', () => expect(padded(null, null, leastSpan('mm'))).toEqual([-1, 1]));
});
