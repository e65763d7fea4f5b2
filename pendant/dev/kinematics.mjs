// A made-up six-axis arm for the mock: joints as {origin, axis}, forward kinematics, and velocities by damped least squares.

export const joints = [
  ['base_joint', 'base', 'shoulder_link', [0, 0, 0.15], [0, 0, 1], 6.28, 3.1],
  ['shoulder_joint', 'shoulder_link', 'upper_arm', [0, 0.11, 0], [0, 1, 0], 6.28, 3.1],
  ['elbow_joint', 'upper_arm', 'forearm', [0.25, -0.09, 0], [0, 1, 0], 2.9, 3.1],
  ['wrist_1_joint', 'forearm', 'wrist_1', [0.22, 0, 0], [0, 1, 0], 6.28, 6.2],
  ['wrist_2_joint', 'wrist_1', 'wrist_2', [0, 0.085, 0], [1, 0, 0], 6.28, 6.2],
  ['wrist_3_joint', 'wrist_2', 'flange', [0.085, 0, 0], [0, 1, 0], 6.28, 6.2],
].map(([name, parent, child, p, axis, limit, velocity]) => ({ name, parent, child, p, axis, limit, velocity }));

const tool = { p: [0, 0.12, 0], q: axisAngle([1, 0, 0], -Math.PI / 2) };
export const tcp = { link: 'flange', ...tool };

export function axisAngle([x, y, z], angle) {
  const s = Math.sin(angle / 2);
  return [x * s, y * s, z * s, Math.cos(angle / 2)];
}
export function times([ax, ay, az, aw], [bx, by, bz, bw]) {
  return [
    aw * bx + ax * bw + ay * bz - az * by,
    aw * by - ax * bz + ay * bw + az * bx,
    aw * bz + ax * by - ay * bx + az * bw,
    aw * bw - ax * bx - ay * by - az * bz,
  ];
}
export function turn(q, v) {
  const [x, y, z] = times(times(q, [...v, 0]), [-q[0], -q[1], -q[2], q[3]]);
  return [x, y, z];
}
const add = (a, b) => a.map((x, i) => x + b[i]);
const sub = (a, b) => a.map((x, i) => x - b[i]);
const cross = ([a, b, c], [x, y, z]) => [b * z - c * y, c * x - a * z, a * y - b * x];

/** The TCP, and where each joint and its axis are. */
export function forward(q) {
  let p = [0, 0, 0];
  let r = [0, 0, 0, 1];
  const axes = joints.map((joint, i) => {
    p = add(p, turn(r, joint.p));
    const at = { p, axis: turn(r, joint.axis) };
    r = times(r, axisAngle(joint.axis, q[i]));
    return at;
  });
  return { p: add(p, turn(r, tool.p)), q: times(r, tool.q), axes };
}

/** Joint velocities for a twist of the TCP, and how close to a singularity it is (0 far, 1 at it). */
export function velocities(q, twist) {
  const now = forward(q);
  const columns = now.axes.map(({ p, axis }) => [...cross(axis, sub(now.p, p)), ...axis]);
  const a = Array.from({ length: 6 }, (_, r) =>
    Array.from({ length: 6 }, (_, c) => columns.reduce((sum, col) => sum + col[r] * col[c], r === c ? 1e-4 : 0)),
  );
  const { x, determinant } = solve(a, twist);
  return { dq: columns.map((col) => col.reduce((sum, v, r) => sum + v * x[r], 0)), singularity: Math.max(0, 1 - Math.sqrt(Math.abs(determinant)) / 0.004) };
}

function solve(a, b) {
  const m = a.map((row, i) => [...row, b[i]]);
  let determinant = 1;
  for (let c = 0; c < 6; ++c) {
    let best = c;
    for (let r = c + 1; r < 6; ++r) if (Math.abs(m[r][c]) > Math.abs(m[best][c])) best = r;
    [m[c], m[best]] = [m[best], m[c]];
    determinant *= m[c][c];
    for (let r = 0; r < 6; ++r) {
      if (r === c) continue;
      const f = m[r][c] / m[c][c];
      for (let k = c; k < 7; ++k) m[r][k] -= f * m[c][k];
    }
  }
  return { x: m.map((row, i) => row[6] / row[i]), determinant };
}
