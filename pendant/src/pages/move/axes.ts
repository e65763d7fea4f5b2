/** The rows of jog keys: the joints of the robot, or the six directions of the TCP. */
import {t} from '../../i18n';
import {robot} from '../../state/cell';
import {jogMode, userFrame} from '../../state/jog';
import {valueNow} from '../../state/live';
import {armOrder, baseNow, frames} from '../../state/models';
import {jointTitle} from '../../ui/format';
import {conjugate, multiply, rollPitchYaw, rotate} from '../../view3d/chain';

import type { JointInfo, Pose, Quat, Vec3 } from '../../wire/types';

export interface Axis {
  name: string;
  /** Colour of a Cartesian axis. */
  color?: 'x' | 'y' | 'z';
  value: number;
  unit: 'm' | 'rad';
  joint?: JointInfo;
  /** The axis number in requests to the cell. */
  index: number;
}

/**
 * The distance from a limit below which a joint counts as near it: a fraction of its range, at most 10° or 20
 * mm.
 */
export function nearLimit(joint: JointInfo): number {
  const range = joint.upper - joint.lower;
  return Math.min(0.08 * range, joint.unit === 'm' ? 0.02 : 0.175);
}

/** The distance of a joint from the limit in the direction of motion; Infinity if it has none. */
export function roomTo(joint: JointInfo, value: number, direction: number): number {
  if (joint.type === 'continuous') return Infinity;
  const room = direction > 0 ? joint.upper - value : value - joint.lower;
  return Number.isFinite(room) ? Math.max(0, room) : Infinity;
}

export function tcpPose(): Pose {
  const name = robot.value?.name ?? '';
  const at = (field: string) => valueNow(`${name}/tcp/${field}`);
  return { p: [at('x'), at('y'), at('z')], q: [at('qx'), at('qy'), at('qz'), at('qw')] };
}

/**
 * The frame in which positions are shown: the base for the modes joint, base and tool; the chosen frame; else
 * the world.
 */
export function shownFrame(): { name: string; pose: Pose } {
  const world = { name: t('move.inWorld'), pose: { p: [0, 0, 0] as Vec3, q: [0, 0, 0, 1] as Quat } };
  if (jogMode.value === 'base' || jogMode.value === 'joint' || jogMode.value === 'tool')
    return { name: t('move.inBase'), pose: robot.value?.base ?? world.pose };
  if (jogMode.value === 'user') {
    const found = frames.value.find((frame) => frame.name === userFrame.value);
    if (found) return { name: found.name, pose: found };
  }
  return world;
}

export function inFrame(pose: Pose, frame: Pose): Pose {
  const back = conjugate(frame.q);
  const p = rotate(back, [pose.p[0] - frame.p[0], pose.p[1] - frame.p[1], pose.p[2] - frame.p[2]]);
  return { p, q: multiply(back, pose.q) };
}

/** The distance between two poses of a base, m. */
const gone = (from: Pose, to: Pose) => Math.hypot(...to.p.map((v, i) => v - from.p[i]!));

export function axesNow(): Axis[] {
  const info = robot.value;
  if (!info) return [];
  if (jogMode.value === 'joint')
    return armOrder(info).map((index) => {
      const joint = info.joints[index]!;
      return { name: jointTitle(joint.name), value: valueNow(`${joint.interface}/position`), unit: joint.unit === 'm' ? 'm' : 'rad', joint, index };
    });
  if (jogMode.value === 'drive') {
    const base = baseNow(info.name) ?? info.base;
    return [
      { name: t('move.ahead'), value: gone(info.base, base), unit: 'm', index: 0 },
      { name: t('move.toLeft'), value: rollPitchYaw(multiply(conjugate(info.base.q), base.q))[2], unit: 'rad', index: 1 },
    ];
  }
  const at = inFrame(tcpPose(), shownFrame().pose);
  const turned = rollPitchYaw(at.q);
  const names = ['x', 'y', 'z'] as const;
  return [
    ...names.map((color, i): Axis => ({ name: color.toUpperCase(), color, value: at.p[i]!, unit: 'm', index: i })),
    ...names.map((color, i): Axis => ({ name: `R${color.toUpperCase()}`, color, value: turned[i]!, unit: 'rad', index: 3 + i })),
  ];
}
