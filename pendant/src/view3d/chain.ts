/**
 * Kinematics of the robot: poses of links and joint axes. For the flat picture, previews and singularities;
 * no WebGL.
 */
import type { ModelJoint, Pose, Quat, RobotModel, Vec3 } from '../wire/types';

export const kIdentity: Quat = [0, 0, 0, 1];

export function multiply([ax, ay, az, aw]: Quat, [bx, by, bz, bw]: Quat): Quat {
  return [
    aw * bx + ax * bw + ay * bz - az * by,
    aw * by - ax * bz + ay * bw + az * bx,
    aw * bz + ax * by - ay * bx + az * bw,
    aw * bw - ax * bx - ay * by - az * bz,
  ];
}

export function rotate([x, y, z, w]: Quat, [a, b, c]: Vec3): Vec3 {
  const tx = 2 * (y * c - z * b);
  const ty = 2 * (z * a - x * c);
  const tz = 2 * (x * b - y * a);
  return [a + w * tx + y * tz - z * ty, b + w * ty + z * tx - x * tz, c + w * tz + x * ty - y * tx];
}

export function conjugate([x, y, z, w]: Quat): Quat {
  return [-x, -y, -z, w];
}

export function aboutAxis([x, y, z]: Vec3, angle: number): Quat {
  const s = Math.sin(angle / 2);
  return [x * s, y * s, z * s, Math.cos(angle / 2)];
}

/** T_ac = T_ab · T_bc: maps `b`, which is given in frame `a`, to the frame in which `a` is given. */
export function compose(a: Pose, b: Pose): Pose {
  const p = rotate(a.q, b.p);
  return { p: [a.p[0] + p[0], a.p[1] + p[1], a.p[2] + p[2]], q: multiply(a.q, b.q) };
}

export function inverse(a: Pose): Pose {
  const q = conjugate(a.q);
  const p = rotate(q, a.p);
  return { p: [-p[0], -p[1], -p[2]], q };
}

/** Roll, pitch, yaw (rad) of a rotation: about x, then y, then z of the fixed frame. */
export function rollPitchYaw([x, y, z, w]: Quat): Vec3 {
  const pitch = Math.asin(Math.max(-1, Math.min(1, 2 * (w * y - z * x))));
  if (Math.abs(Math.abs(pitch) - Math.PI / 2) < 1e-6) return [2 * Math.atan2(x, w), pitch, 0];
  return [
    Math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)),
    pitch,
    Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)),
  ];
}

export function fromRollPitchYaw([roll, pitch, yaw]: Vec3): Quat {
  return multiply(aboutAxis([0, 0, 1], yaw), multiply(aboutAxis([0, 1, 0], pitch), aboutAxis([1, 0, 0], roll)));
}

/** The pose that a joint adds at `value`. */
export function jointPose(joint: ModelJoint, value: number): Pose {
  const [x, y, z] = joint.axis ?? [0, 0, 1];
  if (joint.type === 'revolute' || joint.type === 'continuous') return { p: [0, 0, 0], q: aboutAxis([x, y, z], value) };
  if (joint.type === 'prismatic') return { p: [x * value, y * value, z * value], q: kIdentity };
  return { p: [0, 0, 0], q: kIdentity };
}

/** The value of a joint: its own, or that of the joint that it mimics. */
export function valueOfJoint(joint: ModelJoint, values: (name: string) => number): number {
  const of = joint.mimic ? joint.mimic.multiplier * values(joint.mimic.joint) + joint.mimic.offset : values(joint.name);
  return Number.isFinite(of) ? of : 0;
}

export interface Solved {
  /** The pose of every link in the frame of the root. */
  links: Map<string, Pose>;
  tcp: Pose;
}

export class Chain {
  private readonly order: ModelJoint[] = [];
  constructor(readonly model: RobotModel) {
    const children = new Map<string, ModelJoint[]>();
    for (const joint of model.joints) {
      const list = children.get(joint.parent) ?? [];
      list.push(joint);
      children.set(joint.parent, list);
    }
    const open = [model.root];
    const seen = new Set(open);
    for (let i = 0; i < open.length; ++i)
      for (const joint of children.get(open[i]!) ?? []) {
        if (seen.has(joint.child)) continue;
        seen.add(joint.child);
        this.order.push(joint);
        open.push(joint.child);
      }
  }

  solve(values: (name: string) => number): Solved {
    const links = new Map<string, Pose>([[this.model.root, { p: [0, 0, 0], q: kIdentity }]]);
    for (const joint of this.order) {
      const at = compose(links.get(joint.parent)!, joint.origin);
      links.set(joint.child, compose(at, jointPose(joint, valueOfJoint(joint, values))));
    }
    const { link, ...offset } = this.model.tcp;
    return { links, tcp: compose(links.get(link) ?? { p: [0, 0, 0], q: kIdentity }, offset) };
  }

  /** The joints between the root and the TCP, in order. */
  path(): ModelJoint[] {
    const by = new Map(this.order.map((joint) => [joint.child, joint]));
    const out: ModelJoint[] = [];
    for (let joint = by.get(this.model.tcp.link); joint; joint = by.get(joint.parent)) out.unshift(joint);
    return out;
  }

  /** Lines from link to link, for a robot that is drawn as lines. */
  segments(solved: Solved): [Vec3, Vec3][] {
    const out: [Vec3, Vec3][] = [];
    for (const joint of this.order) {
      const a = solved.links.get(joint.parent)!.p;
      const b = solved.links.get(joint.child)!.p;
      if (Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]) > 1e-4) out.push([a, b]);
    }
    const flange = solved.links.get(this.model.tcp.link);
    if (flange) out.push([flange.p, solved.tcp.p]);
    return out;
  }

  /**
   * The joints that move the TCP, and the columns of the Jacobian: the TCP's linear and angular velocity per
   * unit of joint speed, in the root frame.
   */
  private columns(solved: Solved): { moving: ModelJoint[]; linear: Vec3[]; angular: Vec3[] } {
    const moving = this.path().filter((joint) => joint.type !== 'fixed' && !joint.mimic);
    const linear: Vec3[] = [];
    const angular: Vec3[] = [];
    for (const joint of moving) {
      const at = compose(solved.links.get(joint.parent)!, joint.origin);
      const axis = rotate(at.q, joint.axis);
      const [dx, dy, dz] = solved.tcp.p.map((v, i) => v - at.p[i]!) as Vec3;
      const [x, y, z] = axis;
      const slides = joint.type === 'prismatic';
      linear.push(slides ? axis : [y * dz - z * dy, z * dx - x * dz, x * dy - y * dx]);
      angular.push(slides ? [0, 0, 0] : axis);
    }
    return { moving, linear, angular };
  }

  /**
   * The smallest singular value of the Jacobian, with lengths relative to the reach: how fast the TCP can
   * move in its slowest direction. 0 at a singularity. NaN for arms with fewer than six joints, which always
   * have such directions.
   */
  smallestGain(values: (name: string) => number): number {
    const { moving, linear, angular } = this.columns(this.solve(values));
    if (moving.length < 6) return NaN;
    const reach = Math.max(0.1, this.reach());
    const columns = moving.map((_, k) => [...linear[k]!.map((v) => v / reach), ...angular[k]!]);
    return Math.sqrt(Math.max(0, smallestEigenvalue(gram(columns))));
  }

  reach(): number {
    return this.path().reduce((sum, joint) => sum + Math.hypot(...joint.origin.p), 0) + Math.hypot(...this.model.tcp.p);
  }
}

/** The smallest eigenvalue of a symmetric matrix, by Jacobi's rotations. Changes `m`. */
export function smallestEigenvalue(m: number[][]): number {
  const n = m.length;
  for (let sweep = 0; sweep < 24; ++sweep) {
    let off = 0;
    for (let i = 0; i < n; ++i) for (let j = i + 1; j < n; ++j) off += m[i]![j]! ** 2;
    if (off < 1e-20) break;
    for (let p = 0; p < n; ++p)
      for (let q = p + 1; q < n; ++q) {
        const apq = m[p]![q]!;
        if (Math.abs(apq) < 1e-15) continue;
        const theta = (m[q]![q]! - m[p]![p]!) / (2 * apq);
        const t = (Math.sign(theta) || 1) / (Math.abs(theta) + Math.sqrt(theta * theta + 1));
        const c = 1 / Math.sqrt(t * t + 1);
        const s = t * c;
        for (let k = 0; k < n; ++k) {
          const kp = m[k]![p]!;
          const kq = m[k]![q]!;
          m[k]![p] = c * kp - s * kq;
          m[k]![q] = s * kp + c * kq;
        }
        for (let k = 0; k < n; ++k) {
          const pk = m[p]![k]!;
          const qk = m[q]![k]!;
          m[p]![k] = c * pk - s * qk;
          m[q]![k] = s * pk + c * qk;
        }
      }
  }
  return Math.min(...m.map((row, i) => row[i]!));
}

/** The sum of the outer products of the columns. */
function gram(columns: number[][]): number[][] {
  return Array.from({ length: 6 }, (_, r) =>
    Array.from({ length: 6 }, (_, c) => columns.reduce((sum, column) => sum + column[r]! * column[c]!, 0)),
  );
}
