/** The past path of a TCP, fading with time. */
import * as THREE from 'three';
import type { Vec3 } from '../wire/types';

const kPoints = 900;
const kLeast = 0.0015;

export class Trail {
  readonly line: THREE.Line;
  private readonly points: Vec3[] = [];
  private readonly positions = new THREE.BufferAttribute(new Float32Array(3 * kPoints), 3);
  private readonly colors = new THREE.BufferAttribute(new Float32Array(4 * kPoints), 4);

  constructor() {
    const form = new THREE.BufferGeometry();
    form.setAttribute('position', this.positions);
    form.setAttribute('color', this.colors);
    this.line = new THREE.Line(form, new THREE.LineBasicMaterial({ vertexColors: true, transparent: true, depthWrite: false }));
    this.line.frustumCulled = false;
    form.setDrawRange(0, 0);
  }

  /** Adds a point. Returns true if the change is visible. */
  add(p: Vec3): boolean {
    const last = this.points[this.points.length - 1];
    if (last && Math.hypot(p[0] - last[0], p[1] - last[1], p[2] - last[2]) < kLeast) return false;
    this.points.push(p);
    if (this.points.length > kPoints) this.points.shift();
    const n = this.points.length;
    this.points.forEach((each, i) => {
      this.positions.setXYZ(i, ...each);
      this.colors.setXYZW(i, 1, 0.62, 0.1, 0.15 + (0.85 * i) / n);
    });
    this.positions.needsUpdate = this.colors.needsUpdate = true;
    this.line.geometry.setDrawRange(0, n);
    return true;
  }

  clear(): void {
    this.points.length = 0;
    this.line.geometry.setDrawRange(0, 0);
  }
}
