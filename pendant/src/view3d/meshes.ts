/** Loads meshes as GLB. Each file is loaded once; each link takes its node of it. */
import * as THREE from 'three';
import { GLTFLoader } from 'three/examples/jsm/loaders/GLTFLoader.js';

/** The contents of the files. All copies share their geometry. */
export const readFiles = new Set<THREE.Object3D>();
const files = new Map<string, Promise<THREE.Object3D | null>>();

function file(address: string): Promise<THREE.Object3D | null> {
  let out = files.get(address);
  if (!out) {
    out = new GLTFLoader().loadAsync(address).then(
      (got) => {
        got.scene.traverse((each) => {
          each.userData.ofFile = true;
          if (each instanceof THREE.Mesh) each.castShadow = each.receiveShadow = true;
        });
        readFiles.add(got.scene);
        return got.scene;
      },
      (error: unknown) => {
        console.warn(`${address} cannot be read`, error);
        files.delete(address);
        return null;
      },
    );
    files.set(address, out);
  }
  return out;
}

/** A copy of a node (or of everything) of the file. Copies share geometry. */
export async function meshNode(address: string, node?: string): Promise<THREE.Object3D | null> {
  const all = await file(address);
  if (!all) return null;
  const wanted = node === undefined ? all : findNode(all, node);
  return wanted?.clone(true) ?? null;
}

/** Finds a node by its original name, which GLTFLoader sanitises for its animations and keeps in userData. */
function findNode(all: THREE.Object3D, name: string): THREE.Object3D | null {
  let found: THREE.Object3D | null = null;
  const fitted = THREE.PropertyBinding.sanitizeNodeName(name);
  all.traverse((each) => {
    if (!found && (each.userData.name === name || each.name === name || each.name === fitted)) found = each;
  });
  return found;
}
