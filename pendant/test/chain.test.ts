import { describe, expect, it } from 'vitest';
import { aboutAxis, Chain, compose, fromRollPitchYaw, inverse, multiply, rollPitchYaw, rotate, smallestEigenvalue } from '../src/view3d/chain';
import type { ModelJoint, RobotModel, Vec3 } from '../src/wire/types';

const still = { p: [0, 0, 0] as Vec3, q: [0, 0, 0, 1] as [number, number, number, number] };
function joint(name: string, parent: string, child: string, p: Vec3, axis: Vec3, type = 'revolute'): ModelJoint {
  return { name, type, parent, child, origin: { ...still, p }, axis, mimic: null };
}
function random(seed: number): () => number {
  let state = seed;
  return () => ((state = (state * 1664525 + 1013904223) >>> 0) / 2 ** 32) * 2 - 1;
}

describe('rotations', () => {
  it('come back from roll, pitch and yaw', () => {
    const draw = random(3);
    for (let i = 0; i < 200; ++i) {
      const rpy: Vec3 = [3 * draw(), 1.5 * draw(), 3 * draw()];
      rollPitchYaw(fromRollPitchYaw(rpy)).forEach((v, k) => expect(v).toBeCloseTo(rpy[k]!, 6));
    }
  });
  it('come back at a pitch of 90°, as the same rotation', () => {
    for (const pitch of [Math.PI / 2, -Math.PI / 2]) {
      const q = fromRollPitchYaw([0.4, pitch, 0.9]);
      const again = fromRollPitchYaw(rollPitchYaw(q));
      const [x, y, z] = [rotate(q, [1, 2, 3]), rotate(again, [1, 2, 3])].reduce((a, b) => a.map((v, i) => v - b[i]!) as Vec3);
      expect(Math.hypot(x, y, z)).toBeLessThan(1e-5);
    }
  });
  it('turn as their axes say', () => {
    const [x, y, z] = rotate(aboutAxis([0, 0, 1], Math.PI / 2), [1, 0, 0]);
    expect([x, y, z].map((v) => Math.round(v * 1e9) / 1e9)).toEqual([0, 1, 0]);
  });
  it('have inverses', () => {
    const pose = { p: [1, 2, 3] as Vec3, q: multiply(aboutAxis([0, 1, 0], 0.3), aboutAxis([1, 0, 0], 1)) };
    compose(pose, inverse(pose)).p.forEach((v) => expect(v).toBeCloseTo(0, 12));
  });
});

const planar: RobotModel = {
  root: 'base',
  links: [],
  joints: [
    joint('tip_joint', 'a', 'b', [1, 0, 0], [0, 0, 1]),
    joint('first', 'base', 'a', [0, 0, 0], [0, 0, 1]),
    { ...joint('follower', 'b', 'c', [0, 0, 0], [1, 0, 0], 'prismatic'), mimic: { joint: 'first', multiplier: 2, offset: 0.5 } },
  ],
  tcp: { link: 'b', ...still, p: [1, 0, 0] },
};

describe('Chain', () => {
  it('finds the TCP whatever the order of the joints', () => {
    const at = new Chain(planar).solve((name) => (name === 'first' ? Math.PI / 2 : -Math.PI / 2)).tcp.p;
    [1, 1, 0].forEach((v, i) => expect(at[i]).toBeCloseTo(v, 9));
  });
  it('moves joints that mimic another', () => {
    const solved = new Chain(planar).solve((name) => (name === 'first' ? 0.25 : 0));
    expect(solved.links.get('c')!.p[0]! - solved.links.get('b')!.p[0]!).toBeCloseTo(Math.cos(0.25), 9);
  });
  it('takes joints without a value at zero', () => {
    expect(new Chain(planar).solve(() => NaN).tcp.p[0]).toBeCloseTo(2, 9);
  });
  it('says nothing of singularities where the arm has too few joints', () => expect(new Chain(planar).smallestGain(() => 0)).toBeNaN());
});

const six: RobotModel = {
  root: 'base',
  links: [],
  joints: [
    joint('1', 'base', 'l1', [0, 0, 0.4], [0, 0, 1]),
    joint('2', 'l1', 'l2', [0, 0, 0], [0, 1, 0]),
    joint('3', 'l2', 'l3', [0.4, 0, 0], [0, 1, 0]),
    joint('4', 'l3', 'l4', [0.4, 0, 0], [1, 0, 0]),
    joint('5', 'l4', 'l5', [0, 0, 0], [0, 1, 0]),
    joint('6', 'l5', 'l6', [0, 0, 0], [1, 0, 0]),
  ],
  tcp: { link: 'l6', ...still, p: [0.1, 0, 0] },
};

describe('smallestGain', () => {
  const at = (q: number[]) => new Chain(six).smallestGain((name) => q[Number(name) - 1]!);
  it('is zero with the wrist straight, and with the arm stretched', () => {
    expect(at([0.3, -0.5, 1.2, 0.4, 0, 0.2])).toBeLessThan(1e-6);
    expect(at([0.3, -0.5, 0, 0.4, 0.9, 0.2])).toBeLessThan(1e-6);
  });
  it('grows on the way out', () => {
    const gains = [0.05, 0.2, 0.6].map((bend) => at([0.3, -0.5, 1.2, 0.4, bend, 0.2]));
    expect(gains[0]).toBeGreaterThan(1e-3);
    expect(gains[1]).toBeGreaterThan(gains[0]!);
    expect(gains[2]).toBeGreaterThan(gains[1]!);
  });
});

describe('smallestEigenvalue', () => {
  it('is right for matrices whose eigenvalues are known', () => {
    expect(smallestEigenvalue([[2, 1], [1, 2]])).toBeCloseTo(1, 9);
    expect(smallestEigenvalue([[4, 0, 0], [0, -1, 0], [0, 0, 3]])).toBeCloseTo(-1, 9);
  });
});
