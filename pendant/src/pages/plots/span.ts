/**
 * The smallest span of a plot's y axis for each unit, so that noise below it looks like a line. No side
 * effects.
 */

const kLeast: Record<string, number> = {
  '°': 1, '°/s': 1, '°/s²': 10, rad: 0.02, 'rad/s': 0.02, 'rad/s2': 0.2,
  mm: 1, 'mm/s': 5, 'mm/s²': 50, N: 1, Nm: 0.5, 'N m': 0.5, us: 20, µs: 20, '': 1.2,
};

export const leastSpan = (unit: string) => kLeast[unit] ?? 1e-3;

/** The ends of the y axis around the values. A constant value is in the middle. */
export function padded(min: number | null, max: number | null, least: number): [number, number] {
  if (min === null || max === null || !Number.isFinite(min + max)) return [-least, least];
  const span = Math.max(max - min, least, 1e-6 * Math.max(Math.abs(min), Math.abs(max)));
  const middle = (min + max) / 2;
  return [middle - 0.56 * span, middle + 0.56 * span];
}
