/** Counts the parts that are where they belong. No side effects. */
import type { PartPose, SceneThing, Vec3 } from '../../wire/types';

function isIn(bin: SceneThing, p: Vec3): boolean {
  return bin.visuals[0]?.size?.every((side, i) => Math.abs(p[i]! - bin.p[i]!) <= side / 2 + 1e-6) ?? false;
}

/**
 * `done`: the parts that an outfeed has taken away, and those that lie in the bin of their goal; of parts without
 * such a goal, those that lie in any bin but the one in which they began. `all`: all parts.
 */
export function partsDone(parts: readonly PartPose[], things: readonly SceneThing[]): { done: number; all: number } {
  const bins = things.filter((each) => each.kind === 'bin');
  const isDone = (part: PartPose): boolean => {
    if (part.taken) return true;
    if (!part.here || part.heldBy) return false;
    const first = things.find((each) => each.kind !== 'bin' && each.name === part.name);
    const goals = first?.goalBin ? bins.filter((each) => each.name === first.goalBin) : bins.filter((each) => !first || first.fed || !isIn(each, first.p));
    return goals.some((each) => isIn(each, part.p));
  };
  return { done: parts.filter(isDone).length, all: parts.length };
}
