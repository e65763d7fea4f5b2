/** Objects that pages add to the picture: named points, paths and problems of a dry run. */
import * as THREE from 'three';
import type { DryPath, DryProblem, NamedPose } from '../state/preview';
import { standing } from './labels';
import { axes, place } from './shapes';

const kChosen = 0xffb020;

export class Overlay {
  readonly group = new THREE.Group();
  private readonly points = new THREE.Group();
  private readonly paths = new THREE.Group();
  private readonly problems = new THREE.Group();

  constructor() {
    this.group.add(this.points, this.paths, this.problems);
  }

  setPoints(points: readonly NamedPose[], chosen: readonly string[]): void {
    empty(this.points);
    for (const { name, pose } of points) {
      const picked = chosen.includes(name);
      const frame = axes(picked ? 0.06 : 0.035, picked ? 1 : 0.75);
      frame.add(label(name, picked));
      place(frame, pose);
      this.points.add(frame);
    }
  }

  setDryRun(paths: readonly DryPath[], problems: readonly DryProblem[]): void {
    empty(this.paths);
    empty(this.problems);
    for (const path of paths) {
      const bad = problems.some((problem) => problem.line === path.line && problem.robot === path.robot);
      const form = new THREE.BufferGeometry().setFromPoints(path.points.map((p) => new THREE.Vector3(...p)));
      this.paths.add(new THREE.Line(form, new THREE.LineBasicMaterial({ color: bad ? 0xe5484d : 0x3d8bff })));
    }
    for (const problem of problems) {
      if (!problem.at) continue;
      const mark = new THREE.Mesh(new THREE.SphereGeometry(0.014, 16, 12), new THREE.MeshBasicMaterial({ color: 0xe5484d }));
      mark.position.fromArray(problem.at);
      mark.add(label(String(problem.line), true));
      this.problems.add(mark);
    }
  }
}

/** Removes all objects and frees their memory. */
export function empty(group: THREE.Group): void {
  group.traverse((each) => {
    if (each instanceof THREE.Mesh || each instanceof THREE.Line) {
      each.geometry.dispose();
      (each.material as THREE.Material).dispose();
    }
    if (each instanceof THREE.Sprite) {
      each.material.map?.dispose();
      each.material.dispose();
    }
  });
  group.clear();
}

/** A text that always faces the camera, has the same size on the screen at every distance, and stays inside the view. */
export function label(text: string, strong: boolean, color = strong ? `#${kChosen.toString(16)}` : '#ffffff'): THREE.Sprite {
  const canvas = document.createElement('canvas');
  const pen = canvas.getContext('2d')!;
  const font = `${strong ? 700 : 600} 30px system-ui, sans-serif`;
  pen.font = font;
  canvas.width = Math.ceil(pen.measureText(text).width) + 20;
  canvas.height = 44;
  pen.font = font;
  pen.fillStyle = 'rgb(10 14 19 / 72%)';
  pen.beginPath();
  pen.roundRect(0, 0, canvas.width, canvas.height, 10);
  pen.fill();
  pen.fillStyle = color;
  pen.textBaseline = 'middle';
  pen.fillText(text, 10, 23);
  const map = new THREE.CanvasTexture(canvas);
  map.colorSpace = THREE.SRGBColorSpace;
  const sprite = new THREE.Sprite(new THREE.SpriteMaterial({ map, depthTest: false, sizeAttenuation: false }));
  sprite.scale.set((0.028 * canvas.width) / canvas.height, 0.028, 1);
  sprite.renderOrder = 6;
  sprite.onBeforeRender = (renderer, _, camera) => stand(sprite, canvas.width / canvas.height, renderer, camera);
  return sprite;
}

const kSize = new THREE.Vector2();
const kAt = new THREE.Vector3();

/** Size and place of a label for the view that is drawn now. */
function stand(sprite: THREE.Sprite, aspect: number, renderer: THREE.WebGLRenderer, camera: THREE.Camera): void {
  const view = renderer.getSize(kSize);
  const at = kAt.setFromMatrixPosition(sprite.matrixWorld).project(camera);
  const { width, height, center } = standing([((at.x + 1) * view.x) / 2, ((at.y + 1) * view.y) / 2], aspect, [view.x, view.y]);
  const [across, , , , , up] = camera.projectionMatrix.elements as unknown as number[];
  sprite.center.set(...center);
  sprite.scale.set((2 * width) / (view.x * across!), (2 * height) / (view.y * up!), 1);
  sprite.updateMatrixWorld();
}
