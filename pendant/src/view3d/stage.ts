/** Renderer, camera, light and floor. Draws only after a change, and with less detail on a slow computer. */
import * as THREE from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
import { Floor, lightOfRoom } from './surroundings';

export type ViewName = 'free' | 'front' | 'side' | 'top';

const kDirections: Record<ViewName, [number, number, number]> = {
  free: [1.1, -0.9, 0.75],
  front: [1, 0, 0.02],
  side: [0, -1, 0.02],
  top: [0.001, 0, 1],
};
/** If a picture takes longer than this on average (ms), the detail is reduced. */
const kSlow = 28;
/** Longest pause between two pictures of something that moves, ms. */
const kLongestRest = 200;

/** True if the processor renders. Shadows would then cost more than everything else. */
function drawnBySoftware(gl: WebGLRenderingContext | WebGL2RenderingContext): boolean {
  const known = gl.getExtension('WEBGL_debug_renderer_info');
  const name = known ? String(gl.getParameter(known.UNMASKED_RENDERER_WEBGL)) : '';
  return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
}

export class Stage {
  readonly scene = new THREE.Scene();
  readonly camera = new THREE.PerspectiveCamera(38, 1, 0.02, 200);
  readonly controls: OrbitControls;
  readonly renderer: THREE.WebGLRenderer;
  /** True after the user has turned or moved the view. */
  touched = false;
  readonly floor = new Floor();
  private readonly sun = new THREE.DirectionalLight(0xffffff, 1.5);
  /** With software rendering, one light from above replaces the light of the room. */
  private readonly sky = new THREE.HemisphereLight(0xffffff, 0x8a94a0, 0);
  private room: THREE.Texture | null = null;
  private looked: { view: ViewName; box: THREE.Box3 } | null = null;
  private dark = true;
  private dirty = true;
  private running = true;
  private spent = 0;
  private drawn = 0;
  /** Start time of the last picture; `busy`: the time that a picture takes, averaged (ms). */
  private begun = 0;
  private measured = true;
  private busy = 0;
  private readonly watcher: ResizeObserver;

  constructor(private readonly canvas: HTMLCanvasElement) {
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true, powerPreference: 'high-performance' });
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    const plain = drawnBySoftware(this.renderer.getContext());
    if (plain) this.renderer.setPixelRatio(1);
    this.renderer.shadowMap.enabled = !plain;
    this.renderer.shadowMap.type = THREE.PCFShadowMap;
    this.renderer.toneMapping = THREE.NeutralToneMapping;
    if (!plain) this.room = lightOfRoom(this.renderer);
    this.scene.environment = this.room;
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = false;
    this.controls.minDistance = 0.08;
    this.controls.maxDistance = 60;
    this.controls.addEventListener('change', () => this.redraw());
    this.controls.addEventListener('start', () => (this.touched = true));
    this.sun.castShadow = !plain;
    this.sun.shadow.mapSize.set(1024, 1024);
    this.sun.shadow.normalBias = 0.02;
    this.sun.shadow.radius = 4;
    this.scene.add(this.sky, this.sun, this.sun.target, this.floor.group);
    this.watcher = new ResizeObserver(() => this.resize());
    this.watcher.observe(canvas.parentElement ?? canvas);
    this.resize();
    const loop = (now: number) => {
      if (!this.running) return;
      requestAnimationFrame(loop);
      this.draw(now);
    };
    requestAnimationFrame(loop);
  }

  redraw(): void {
    this.dirty = true;
  }

  /**
   * Draws a picture. Its time counts until the browser's next animation frame, which waits for the graphics.
   */
  private draw(now: number): void {
    if (!this.measured) this.measure(now - this.begun);
    // On a slow computer, leaves as much time for other work as a picture takes.
    const rest = this.busy > kSlow ? Math.min(2 * this.busy, kLongestRest) : 0;
    if (!this.dirty || document.hidden || now - this.begun < rest) return;
    this.dirty = this.measured = false;
    this.begun = now;
    this.renderer.render(this.scene, this.camera);
  }

  private measure(took: number): void {
    this.measured = true;
    if (took > 1000) return;
    this.busy += 0.2 * (took - this.busy);
    this.spent += took;
    if (++this.drawn < 30) return;
    if (this.spent / this.drawn > kSlow) this.plainer();
    this.spent = this.drawn = 0;
  }

  private plainer(): void {
    if (this.renderer.getPixelRatio() > 1) this.renderer.setPixelRatio(1);
    else if (this.sun.castShadow) this.sun.castShadow = false;
    else if (this.room) this.leaveRoom();
    else if (this.renderer.getPixelRatio() > 0.7) this.renderer.setPixelRatio(0.7);
    this.resize();
  }

  private leaveRoom(): void {
    this.room?.dispose();
    this.scene.environment = this.room = null;
    this.lightUp(this.dark);
  }

  private resize(): void {
    const box = this.canvas.parentElement?.getBoundingClientRect();
    if (!box || box.width < 2 || box.height < 2) return;
    this.renderer.setSize(box.width, box.height, false);
    this.camera.aspect = box.width / box.height;
    this.camera.updateProjectionMatrix();
    if (!this.touched && this.looked) this.look(this.looked.view, this.looked.box);
    this.redraw();
  }

  setFloor(height: number, dark: boolean): void {
    this.floor.set(height, dark, this.sun.castShadow);
    this.scene.environmentIntensity = dark ? 0.62 : 0.8;
    this.lightUp(dark);
    this.redraw();
  }

  private lightUp(dark: boolean): void {
    this.dark = dark;
    this.sky.groundColor.set(dark ? 0x4a5560 : 0x98a2ac);
    this.sky.intensity = this.room ? 0 : dark ? 2.4 : 2.9;
    this.sun.intensity = this.room ? (dark ? 1.3 : 1.5) : dark ? 2.2 : 2.3;
  }

  /** Points the camera at `box` from the given direction, so that all of it is visible. */
  look(view: ViewName, box: THREE.Box3): void {
    this.looked = { view, box: box.clone() };
    const sphere = box.isEmpty() ? new THREE.Sphere(new THREE.Vector3(0, 0, 0.4), 0.8) : box.getBoundingSphere(new THREE.Sphere());
    const half = THREE.MathUtils.degToRad(this.camera.fov / 2);
    const narrow = Math.min(half, Math.atan(Math.tan(half) * this.camera.aspect));
    const distance = (sphere.radius * 0.94) / Math.sin(narrow);
    this.controls.target.copy(sphere.center);
    this.camera.position.copy(sphere.center).addScaledVector(new THREE.Vector3(...kDirections[view]).normalize(), distance);
    this.controls.update();
    this.light(sphere);
    this.redraw();
  }

  /** The direction of the last look(). */
  get view(): ViewName {
    return this.looked?.view ?? 'free';
  }

  /** Moves the view by this vector, to follow a moving object. */
  follow(by: THREE.Vector3): void {
    for (const each of [this.controls.target, this.camera.position, this.sun.target.position, this.sun.position]) each.add(by);
    this.looked?.box.translate(by);
    this.controls.update();
    this.redraw();
  }

  private light(around: THREE.Sphere): void {
    const r = Math.max(around.radius, 0.3) * 1.3;
    this.sun.target.position.copy(around.center);
    this.sun.position.copy(around.center).add(new THREE.Vector3(0.5, -0.35, 1).multiplyScalar(3 * r));
    const camera = this.sun.shadow.camera;
    [camera.left, camera.right, camera.top, camera.bottom, camera.near, camera.far] = [-r, r, r, -r, 0.01, 6 * r];
    camera.updateProjectionMatrix();
  }

  /** Arrow keys turn the view, + and − zoom. Returns true if it was one of these keys. */
  key(key: string): boolean {
    const offset = this.camera.position.clone().sub(this.controls.target);
    const round = new THREE.Spherical().setFromVector3(new THREE.Vector3(offset.x, offset.z, -offset.y));
    const steps: Record<string, () => void> = {
      ArrowLeft: () => (round.theta -= 0.12),
      ArrowRight: () => (round.theta += 0.12),
      ArrowUp: () => (round.phi -= 0.1),
      ArrowDown: () => (round.phi += 0.1),
      '+': () => (round.radius /= 1.12),
      '-': () => (round.radius *= 1.12),
    };
    const step = steps[key];
    if (!step) return false;
    step();
    round.makeSafe();
    const turned = new THREE.Vector3().setFromSpherical(round);
    this.camera.position.copy(this.controls.target).add(new THREE.Vector3(turned.x, -turned.z, turned.y));
    this.controls.update();
    this.redraw();
    return true;
  }

  end(): void {
    this.running = false;
    this.watcher.disconnect();
    this.controls.dispose();
    this.floor.end();
    this.room?.dispose();
    this.sun.dispose();
    this.renderer.dispose();
    // Otherwise the context lives until its canvas is collected, and a browser has only a few contexts.
    this.renderer.forceContextLoss();
  }
}
