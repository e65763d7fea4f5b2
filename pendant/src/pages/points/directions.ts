/** Where a hand points, and how far joints have turned between samples. No side effects. */
import { t } from '../../i18n';
import type { Quat } from '../../wire/types';
import { kDeg } from '../../ui/format';

/** Angle between the z axis of the hand and straight down, rad. */
export function fromDown([x, y]: Quat): number {
  return Math.acos(Math.min(1, Math.max(-1, 2 * (x * x + y * y) - 1)));
}

/** Where the hand points, in words. */
export function pointing(q: Quat): string {
  const lean = fromDown(q) * kDeg;
  if (lean < 10) return t('calibrate.isDown');
  if (lean > 170) return t('calibrate.isUp');
  return t('calibrate.isLeaning', { degrees: Math.round(lean) });
}

/** The joints that turn and whose values differ by less than `least`, in rad, in all samples; in their order. */
export function hardlyTurned(samples: Record<string, number>[], least: number, joints: readonly { name: string; unit: string }[]): string[] {
  if (samples.length === 0) return [];
  return Object.keys(samples[0]!).filter((joint) => {
    if (joints.find((each) => each.name === joint)?.unit === 'm') return false;
    const values = samples.map((each) => each[joint] ?? 0);
    return Math.max(...values) - Math.min(...values) < least;
  });
}
