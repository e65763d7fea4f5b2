// Labels of the picture stay whole inside the view, and as large in a small view as in a large one.
import { expect, it } from 'vitest';
import { standing } from '../src/view3d/labels';

const kView = [390, 260] as const;
/** Left, right, bottom and top of the label, px. */
function edges(at: readonly [number, number], aspect: number) {
  const { width, height, center } = standing(at, aspect, kView);
  return [at[0] - center[0] * width, at[0] + (1 - center[0]) * width, at[1] - center[1] * height, at[1] + (1 - center[1]) * height];
}

it('stands beside its place, above it', () => {
  const [left, , bottom] = edges([100, 100], 5);
  expect(left).toBeGreaterThan(100);
  expect(bottom).toBeGreaterThan(100);
});

it('does not leave the view at its edges', () => {
  for (const x of [0, 5, 195, 380, 390])
    for (const y of [0, 3, 130, 255, 260])
      for (const aspect of [1.5, 8, 15, 60]) {
        const [left, right, bottom, top] = edges([x, y], aspect);
        expect(Math.min(left!, bottom!, kView[0] - right!, kView[1] - top!), `${x} ${y} ${aspect}`).toBeGreaterThanOrEqual(3.999);
      }
});

it('is not hidden behind the keys in the corner', () => {
  const [, right] = edges([380, 200], 8);
  expect(right).toBeLessThanOrEqual(kView[0] - 60);
  expect(edges([380, 40], 8)[1]).toBeGreaterThan(kView[0] - 60);
});

it('is smaller only where it would be wider than the view', () => {
  expect(standing([100, 100], 8, kView).height).toBe(standing([100, 100], 8, [1280, 800]).height);
  expect(standing([100, 100], 60, kView).height).toBeLessThan(standing([100, 100], 8, kView).height);
});

it('goes with a place outside the view', () => {
  const [left] = edges([450, 100], 5);
  expect(left).toBeGreaterThan(450);
});
