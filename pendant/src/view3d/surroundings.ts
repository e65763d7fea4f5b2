/**
 * The surroundings of the robots: ambient light, a floor with a scale, and soft shadows below objects. All
 * generated here.
 */
import * as THREE from 'three';

/** Side lengths of the small and large squares of the floor's grid, m. */
const kSmall = 0.1;
const kLarge = 0.5;
const kHalf = 4;

/** A room with a bright ceiling and two windows, as ambient light for a scene. */
export function lightOfRoom(renderer: THREE.WebGLRenderer): THREE.Texture {
  const room = new THREE.Scene();
  const panel = (color: number, strength: number, size: [number, number, number], at: [number, number, number]) => {
    const look = new THREE.MeshBasicMaterial({ color: new THREE.Color(color).multiplyScalar(strength) });
    const mesh = new THREE.Mesh(new THREE.BoxGeometry(...size), look);
    mesh.position.set(...at);
    room.add(mesh);
  };
  const walls = new THREE.Mesh(
    new THREE.SphereGeometry(12, 24, 16),
    new THREE.MeshBasicMaterial({ color: 0xaab2ba, side: THREE.BackSide }),
  );
  room.add(walls);
  panel(0x70757b, 1, [30, 30, 0.5], [0, 0, -6]);
  panel(0xffffff, 5, [7, 7, 0.2], [0, 0, 8]);
  panel(0xfff4e6, 6, [0.2, 5, 3], [8, -3, 4]);
  panel(0xe8f1ff, 4, [5, 0.2, 3], [-3, -8, 3]);
  panel(0xe8f1ff, 3, [0.2, 5, 4], [-8, 2, 3]);
  const maker = new THREE.PMREMGenerator(renderer);
  const out = maker.fromScene(room, 0.035).texture;
  maker.dispose();
  room.traverse((each) => {
    if (!(each instanceof THREE.Mesh)) return;
    each.geometry.dispose();
    (each.material as THREE.Material).dispose();
  });
  return out;
}

/** Lines of a grid that fade with the distance from the middle. */
function grid(step: number, skip: number, color: number, opacity: number): THREE.LineSegments {
  const at: number[] = [];
  const tint: number[] = [];
  const c = new THREE.Color(color);
  const pieces = 16;
  const n = Math.round(kHalf / step);
  for (let i = -n; i <= n; ++i) {
    if (skip && i % skip === 0) continue;
    for (let k = 0; k < pieces; ++k)
      for (const across of [false, true]) {
        for (const end of [k, k + 1]) {
          const along = kHalf * (2 * (end / pieces) - 1);
          const [x, y] = across ? [along, i * step] : [i * step, along];
          at.push(x, y, 0);
          tint.push(c.r, c.g, c.b, opacity * Math.max(0, 1 - Math.hypot(x, y) / kHalf));
        }
      }
  }
  const form = new THREE.BufferGeometry();
  form.setAttribute('position', new THREE.Float32BufferAttribute(at, 3));
  form.setAttribute('color', new THREE.Float32BufferAttribute(tint, 4));
  const out = new THREE.LineSegments(form, new THREE.LineBasicMaterial({ vertexColors: true, transparent: true, depthWrite: false }));
  out.renderOrder = -2;
  return out;
}

export class Floor {
  readonly group = new THREE.Group();
  private readonly spot: THREE.CanvasTexture;
  private readonly shade = new THREE.ShadowMaterial({ opacity: 0.3, depthWrite: false });

  constructor() {
    this.spot = softSpot();
  }

  /** `shadows`: the renderer casts shadows, for which the floor needs a surface. */
  set(height: number, dark: boolean, shadows: boolean): void {
    this.clear();
    this.group.position.z = height - 0.0015;
    const [fine, strong] = dark ? [0x5d6e80, 0x8296ab] : [0x7f8d9b, 0x64727f];
    this.group.add(grid(kSmall, Math.round(kLarge / kSmall), fine, dark ? 0.3 : 0.34), grid(kLarge, 0, strong, dark ? 0.6 : 0.55));
    const ground = new THREE.Mesh(new THREE.PlaneGeometry(2 * kHalf, 2 * kHalf), this.shade);
    ground.receiveShadow = true;
    ground.renderOrder = -1;
    ground.visible = shadows;
    this.shade.opacity = dark ? 0.45 : 0.24;
    this.group.add(ground);
  }

  /** Adds a soft contact shadow on the floor at `at`, below an object of this radius (m). */
  addSpot(at: THREE.Vector3, radius: number): THREE.Mesh {
    const look = new THREE.MeshBasicMaterial({ map: this.spot, color: 0x000000, transparent: true, depthWrite: false, opacity: 0.5 });
    const out = new THREE.Mesh(new THREE.PlaneGeometry(3.4 * radius, 3.4 * radius), look);
    out.position.copy(at);
    out.renderOrder = -1;
    return out;
  }

  private clear(): void {
    for (const each of this.group.children) {
      (each as THREE.Mesh).geometry.dispose();
      const look = (each as THREE.Mesh).material as THREE.Material;
      if (look !== this.shade) look.dispose();
    }
    this.group.clear();
  }

  end(): void {
    this.clear();
    this.shade.dispose();
    this.spot.dispose();
  }
}

function softSpot(): THREE.CanvasTexture {
  const canvas = document.createElement('canvas');
  canvas.width = canvas.height = 128;
  const pen = canvas.getContext('2d')!;
  const fade = pen.createRadialGradient(64, 64, 0, 64, 64, 64);
  for (const [at, opacity] of [[0, 1], [0.42, 0.85], [0.55, 0.5], [0.75, 0.15], [1, 0]] as const)
    fade.addColorStop(at, `rgb(255 255 255 / ${100 * opacity}%)`);
  pen.fillStyle = fade;
  pen.fillRect(0, 0, 128, 128);
  return new THREE.CanvasTexture(canvas);
}
