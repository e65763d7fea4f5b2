/** Uploads mesh files for the scene, and proposes how they are placed. */
import type { Vec3 } from '../../wire/types';
import { request } from '../../state/cell';

/** Bytes of one piece; as base64 it stays below the limit of a request. */
const kPiece = 384 * 1024;
export const kEndings = ['.stl', '.obj', '.dae', '.3mf', '.glb', '.gltf', '.ply', '.step', '.stp'];
const kCompanions = ['.mtl', '.png', '.jpg', '.jpeg'];
export const kUnits: Record<string, number> = { m: 1, mm: 0.001, cm: 0.01, in: 0.0254 };

/** A mesh in the folder of the cell. */
export interface Uploaded {
  file: string;
  size: Vec3;
  lower: Vec3;
  triangles: number;
  metres: boolean;
  likely: string;
}

const endingOf = (name: string) => name.slice(name.lastIndexOf('.')).toLowerCase();
export const isMesh = (name: string) => kEndings.includes(endingOf(name));
const isCompanion = (name: string) => kCompanions.includes(endingOf(name));

/** Characters that the cell does not take in file names become _. */
export const fileName = (name: string) => name.replace(/[^A-Za-z0-9_. -]/g, '_').replace(/^[. ]+/, '');

/** A name for the scene: a word that begins with a letter. */
export function sceneName(file: string): string {
  const stem = file.slice(file.lastIndexOf('/') + 1).replace(/\.[^.]*$/, '');
  const word = stem.replace(/[^A-Za-z0-9_]/g, '_').slice(0, 60);
  return /^[A-Za-z_]/.test(word) ? word : `mesh_${word}`;
}

export function base64(bytes: Uint8Array): string {
  let text = '';
  for (let i = 0; i < bytes.length; i += 0x8000) text += String.fromCharCode(...bytes.subarray(i, i + 0x8000));
  return btoa(text);
}

/** Sends the files: images and materials first, so that the meshes find them. `progress`: from 0 to 1. */
export async function upload(files: File[], progress: (share: number) => void): Promise<Uploaded[]> {
  const wanted = [...files.filter((each) => isCompanion(each.name)), ...files.filter((each) => isMesh(each.name))];
  const all = wanted.reduce((sum, each) => sum + each.size, 0) || 1;
  let sent = 0;
  const out: Uploaded[] = [];
  for (const each of wanted) {
    let offset = 0;
    do {
      const piece = new Uint8Array(await each.slice(offset, offset + kPiece).arrayBuffer());
      const last = offset + piece.length >= each.size;
      const answer = await request('scene.upload', { name: fileName(each.name), offset, data: base64(piece), last }, 120_000);
      offset += piece.length;
      sent += piece.length;
      progress(sent / all);
      if (answer.mesh) out.push({ file: answer.file, ...answer.mesh });
    } while (offset < each.size);
  }
  return out;
}

/** Where the mesh stands on the floor in front of the robot. */
export function place(mesh: Uploaded, unit: string): Vec3 {
  const metres = mesh.metres ? 1 : (kUnits[unit] ?? 1);
  const round = (value: number) => Math.round(value * 1e6) / 1e6;
  return [0.5, 0, round(-mesh.lower[2] * metres)];
}
