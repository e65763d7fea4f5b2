/** Shapes of the wire as three.js objects. Metres, z up. */
import * as THREE from 'three';
import { RoundedBoxGeometry } from 'three/examples/jsm/geometries/RoundedBoxGeometry.js';
import type { Pose, Visual } from '../wire/types';
import { meshNode, readFiles } from './meshes';

const kPlain: [number, number, number, number] = [0.74, 0.77, 0.81, 1];
/** Edge radius of boxes, m. */
const kRounding = 0.003;
const materials = new Map<string, THREE.MeshStandardMaterial>();

export function material(color: readonly number[] = kPlain): THREE.MeshStandardMaterial {
  const key = color.map((c) => c.toFixed(3)).join();
  let out = materials.get(key);
  if (!out) {
    const alpha = color[3] ?? 1;
    out = new THREE.MeshStandardMaterial({
      color: new THREE.Color().setRGB(color[0] ?? 0.7, color[1] ?? 0.7, color[2] ?? 0.7, THREE.SRGBColorSpace),
      roughness: 0.5,
      metalness: 0,
      transparent: alpha < 0.99,
      opacity: alpha,
      depthWrite: alpha > 0.5,
    });
    materials.set(key, out);
  }
  return out;
}

export function place(object: THREE.Object3D, pose: Pose): void {
  object.position.fromArray(pose.p);
  object.quaternion.fromArray(pose.q).normalize();
}

function geometry(visual: Visual): THREE.BufferGeometry | null {
  const radius = visual.radius ?? 0.01;
  const length = visual.length ?? 0.01;
  switch (visual.shape) {
    case 'box': {
      const [x, y, z] = visual.size ?? [0.01, 0.01, 0.01];
      return new RoundedBoxGeometry(x, y, z, 2, Math.min(kRounding, 0.2 * Math.min(x, y, z)));
    }
    case 'sphere':
      return new THREE.SphereGeometry(radius, 28, 18);
    // Cylinders of three.js lie along y.
    case 'cylinder':
      return new THREE.CylinderGeometry(radius, radius, length, 32).rotateX(Math.PI / 2);
    case 'capsule':
      return new THREE.CapsuleGeometry(radius, length, 8, 24).rotateX(Math.PI / 2);
    default:
      return null;
  }
}

/** Many boxes as one object: the body of a point cloud. Six numbers each: the middle and the edges. */
function boxes(visual: Visual): THREE.Object3D {
  const all = visual.boxes ?? [];
  const out = new THREE.InstancedMesh(new THREE.BoxGeometry(1, 1, 1), material(visual.color), all.length / 6);
  const at = new THREE.Matrix4();
  for (let i = 0; 6 * i < all.length; ++i) {
    const [x, y, z, dx, dy, dz] = all.slice(6 * i, 6 * i + 6) as [number, number, number, number, number, number];
    out.setMatrixAt(i, at.makeScale(dx, dy, dz).setPosition(x, y, z));
  }
  out.computeBoundingSphere();
  return out;
}

/** One shape at its pose. A mesh is added to the returned group when it is loaded; `ready` is then called. */
export function shape(visual: Visual, ready: () => void, edges = false): THREE.Object3D {
  const group = new THREE.Group();
  place(group, visual.origin);
  const form = geometry(visual);
  if (visual.shape === 'boxes') {
    group.add(boxes(visual));
  } else if (form) {
    const mesh = new THREE.Mesh(form, material(visual.color));
    mesh.castShadow = mesh.receiveShadow = true;
    group.add(mesh);
    if (edges && visual.shape === 'box') group.add(outline(new THREE.BoxGeometry(...(visual.size ?? [0.01, 0.01, 0.01]))));
  } else if (visual.shape === 'mesh' && visual.mesh) {
    if (visual.scale) group.scale.fromArray(visual.scale);
    void meshNode(visual.mesh, visual.node).then((node) => {
      if (!node) return;
      group.add(node);
      ready();
    });
  }
  return group;
}

/**
 * Frees the graphics memory of an object that is no longer shown. Keeps shared materials and the meshes of
 * files.
 */
export function dispose(object: THREE.Object3D): void {
  object.traverse((each) => {
    if (!(each instanceof THREE.Mesh || each instanceof THREE.Line)) return;
    if (!each.userData.ofFile) each.geometry.dispose();
    if (each.material instanceof THREE.LineBasicMaterial && each.material !== lineMaterial) each.material.dispose();
  });
}

/**
 * Frees everything when the picture is removed. Each drawn object keeps a reference to its renderer, and with
 * it the canvas and the page, until it is disposed of. Shared objects are freed too; the next picture uploads
 * them again.
 */
export function disposeAll(scene: THREE.Object3D): void {
  const all = (object: THREE.Object3D) =>
    object.traverse((each) => {
      if (!(each instanceof THREE.Mesh || each instanceof THREE.Line || each instanceof THREE.Sprite)) return;
      each.geometry.dispose();
      for (const look of [each.material].flat() as (THREE.Material & { map?: THREE.Texture | null })[]) {
        look.map?.dispose();
        look.dispose();
      }
    });
  all(scene);
  for (const file of readFiles) all(file);
  for (const look of materials.values()) look.dispose();
  lineMaterial.dispose();
}

const lineMaterial = new THREE.LineBasicMaterial({ color: 0x000000, transparent: true, opacity: 0.16 });
function outline(form: THREE.BufferGeometry): THREE.LineSegments {
  const out = new THREE.LineSegments(new THREE.EdgesGeometry(form), lineMaterial);
  form.dispose();
  return out;
}

/** Three short axes in red, green and blue: x, y, z. */
export function axes(size: number, opacity = 1): THREE.LineSegments {
  const out = new THREE.AxesHelper(size);
  out.setColors(0xe5484d, 0x2ea56a, 0x4d8dff);
  const look = out.material as THREE.LineBasicMaterial;
  look.transparent = opacity < 1;
  look.opacity = opacity;
  look.depthTest = false;
  out.renderOrder = 5;
  return out;
}
