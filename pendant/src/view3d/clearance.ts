/** Distances of robots from everything else: as colours, and a line between the two nearest bodies. */
import * as THREE from 'three';

import {number, t} from '../i18n';
import {bodyWords} from '../i18n/told';

import type { Near } from '../wire/types';
import { empty, label } from './overlay';

/** Distances from which on something is far, and up to which it is very near, m. */
const kFar = 0.1;
const kClose = 0.005;
const kStops = [0xe5484d, 0xffb020, 0x2ea56a, 0x3d8bff].map((color) => new THREE.Color(color));

/** Red: very near, through amber and green to blue: far. An unknown distance is blue. */
export function clearanceColor(distance: number | undefined): THREE.Color {
  const far = distance === undefined || !Number.isFinite(distance) ? 1 : THREE.MathUtils.clamp((distance - kClose) / (kFar - kClose), 0, 1);
  const at = far * (kStops.length - 1);
  const i = Math.min(Math.floor(at), kStops.length - 2);
  return kStops[i]!.clone().lerp(kStops[i + 1]!, at - i);
}

/** Where a robot is nearest to something, with both names and the distance. */
export class Nearest {
  readonly group = new THREE.Group();
  private told = '';

  /** True if the picture changed. */
  show(nears: readonly Near[]): boolean {
    const near = nears.filter((each) => each.distance < kFar && each.onA && each.onB);
    const told = JSON.stringify(near);
    if (told === this.told) return false;
    this.told = told;
    empty(this.group);
    for (const each of near) {
      const ends = [new THREE.Vector3(...each.onA), new THREE.Vector3(...each.onB)] as const;
      const color = clearanceColor(each.distance);
      const line = new THREE.Line(
        new THREE.BufferGeometry().setFromPoints([...ends]),
        new THREE.LineBasicMaterial({ color, depthTest: false }),
      );
      line.renderOrder = 6;
      this.group.add(line);
      for (const end of ends) {
        const ball = new THREE.Mesh(new THREE.SphereGeometry(0.006, 12, 8), new THREE.MeshBasicMaterial({ color, depthTest: false }));
        ball.renderOrder = 6;
        ball.position.copy(end);
        this.group.add(ball);
      }
      const text = label(
          t('view.near', { a: bodyWords(each.a), b: bodyWords(each.b), mm: number(1000 * each.distance, 0) }), true,
          `#${color.getHexString()}`);
      text.position.copy(ends[1]);
      this.group.add(text);
    }
    return true;
  }
}
