/** Unexpected contacts: both bodies in red, and between them a mark with their names and the depth. */
import * as THREE from 'three';

import {number, t} from '../i18n';
import {bodyWords} from '../i18n/told';

import type { Touch } from '../wire/types';
import { empty, label } from './overlay';

const kRed = 0xe5484d;
const kMost = 8;

export class Contacts {
  readonly group = new THREE.Group();
  private readonly painted = new Map<THREE.Mesh, THREE.Material | THREE.Material[]>();
  private readonly look = new THREE.MeshStandardMaterial({ color: kRed, emissive: 0x5a0a0e, roughness: 0.5 });

  /** `body`: the body of a name that contacts use, `arm/forearm_link` or `fixture table`. */
  show(touches: readonly Touch[], body: (name: string) => THREE.Object3D | undefined): void {
    for (const [mesh, material] of this.painted) mesh.material = material;
    this.painted.clear();
    empty(this.group);
    for (const touch of touches.slice(0, kMost)) {
      for (const name of [touch.a, touch.b]) this.paint(body(name));
      this.mark(touch, body);
    }
  }

  end(): void {
    this.look.dispose();
    for (const material of this.painted.values()) for (const each of [material].flat()) each.dispose();
  }

  /** Paints the meshes of a body, but not those of bodies that a joint connects to it. */
  private paint(body: THREE.Object3D | undefined): void {
    if (!body) return;
    const open = [body];
    for (let each = open.pop(); each; each = open.pop()) {
      if (each !== body && each.userData.joint) continue;
      if (each instanceof THREE.Mesh && !this.painted.has(each)) {
        this.painted.set(each, each.material as THREE.Material);
        each.material = this.look;
      }
      open.push(...each.children);
    }
  }

  private mark(touch: Touch, body: (name: string) => THREE.Object3D | undefined): void {
    const at = touch.at ? new THREE.Vector3(...touch.at) : middle(body(touch.a) ?? body(touch.b));
    if (!at) return;
    const ball = new THREE.Mesh(new THREE.SphereGeometry(0.012, 16, 12), new THREE.MeshBasicMaterial({ color: kRed, depthTest: false }));
    ball.renderOrder = 6;
    ball.position.copy(at);
    ball.add(label(
        t('view.contact', {a: bodyWords(touch.a), b: bodyWords(touch.b), mm: number(1000 * touch.depth, 1)}),
        true, '#ff9a9e'));
    this.group.add(ball);
  }
}

function middle(body: THREE.Object3D | undefined): THREE.Vector3 | null {
  return body ? new THREE.Box3().setFromObject(body).getCenter(new THREE.Vector3()) : null;
}
