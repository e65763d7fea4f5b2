/** The cell in 3D: robots, scene, parts, frames, trail, plan, ghost, and the handle to drag the TCP. */
import * as THREE from 'three';
import { TransformControls } from 'three/examples/jsm/controls/TransformControls.js';
import type { Near, PartPose, Plan, Pose, RobotInfo, RobotModel, SceneInfo, SceneThing, Touch, Vec3 } from '../wire/types';
import type { DryPath, DryProblem, NamedPose } from '../state/preview';
import { compose, inverse } from './chain';
import { RobotFigure } from './figure';
import { clearanceColor, Nearest } from './clearance';
import { nameInPicture } from './bodies';
import { Contacts } from './contacts';
import { empty, label, Overlay } from './overlay';
import { axes, dispose, disposeAll, place, shape } from './shapes';
import { Stage, type ViewName } from './stage';
import { Trail } from './trail';

export interface Layers {
  trail: boolean;
  plan: boolean;
  frames: boolean;
  zones: boolean;
  things: boolean;
  names: boolean;
  near: boolean;
}

export interface Ghost {
  robot: string;
  joints: Record<string, number>;
}

export interface Handle {
  pose: Pose;
  turn: boolean;
  local: boolean;
  onDrag: (pose: Pose) => void;
  onHold: (held: boolean) => void;
}

const kZoneKinds = ['zone', 'camera', 'sensor', 'feeder', 'outfeed', 'bin'];

function stands(object: THREE.Object3D, { p, q }: Pose): boolean {
  const { position, quaternion } = object;
  return position.x === p[0] && position.y === p[1] && position.z === p[2] && quaternion.equals(new THREE.Quaternion(...q));
}

/** The approximate width of a robot's foot, m. */
function footOf(model: RobotModel): number {
  const way = model.joints.reduce((sum, joint) => sum + Math.hypot(...joint.origin.p), 0);
  return Math.min(0.5, Math.max(0.05, 0.06 * way + 0.02));
}

/** The name of a thing above it. */
function nameOf(thing: THREE.Object3D): THREE.Object3D {
  const box = new THREE.Box3().setFromObject(thing);
  const out = label(thing.name, false);
  if (box.isEmpty()) out.position.copy(thing.position);
  else box.getCenter(out.position).setZ(box.max.z);
  return out;
}

export class CellPicture {
  readonly stage: Stage;
  private readonly robots = new Map<string, RobotFigure>();
  private readonly ghosts = new Map<string, RobotFigure>();
  /**
   * For each robot: the world as it was when its base was at `base`. The robot's program and points refer to
   * it, so it moves with the base.
   */
  private readonly grounds = new Map<string, { group: THREE.Group; base: Pose }>();
  private readonly signs = new Map<string, THREE.Group>();
  private readonly things = new THREE.Group();
  private readonly zones = new THREE.Group();
  private readonly frames = new THREE.Group();
  private readonly overlay = new Overlay();
  private readonly contacts = new Contacts();
  /** The part that each robot holds. */
  private readonly held = new Map<string, string>();
  private readonly nearest = new Nearest();
  private readonly names = new THREE.Group();
  private readonly moving = new Map<string, THREE.Object3D>();
  private readonly carried: { object: THREE.Object3D; home: THREE.Vector3; axis: THREE.Vector3; field: string }[] = [];
  private readonly trails = new Map<string, Trail>();
  private readonly paths = new Map<string, THREE.Line>();
  private readonly ghostLook = new THREE.MeshStandardMaterial({
    color: 0x3d8bff,
    transparent: true,
    opacity: 0.34,
    // Shows only its front surface, not the housings inside.
    depthWrite: true,
    roughness: 0.6,
    // Drawn slightly behind objects at the same place, so that the two do not flicker.
    polygonOffset: true,
    polygonOffsetFactor: 2,
    polygonOffsetUnits: 8,
  });
  private readonly redraw = () => this.stage.redraw();
  /**
   * Meshes load later than the objects that they belong to. Fits the view to them unless the user has changed
   * it.
   */
  private readonly come = () => {
    if (this.framed && !this.stage.touched) this.fit(this.stage.view);
    this.redraw();
  };
  private handle: { controls: TransformControls; object: THREE.Object3D; told: Handle } | null = null;
  private shown = '';
  private framed = false;
  private floor = 0;
  private dark = true;
  private layers: Layers = { trail: true, plan: true, frames: false, zones: true, things: true, names: false, near: true };

  constructor(canvas: HTMLCanvasElement) {
    this.stage = new Stage(canvas);
    this.stage.scene.add(this.things, this.zones, this.frames, this.overlay.group, this.contacts.group, this.nearest.group, this.names);
  }

  setTheme(dark: boolean): void {
    this.dark = dark;
    this.stage.setFloor(this.floor, dark);
  }

  setRobots(robots: RobotInfo[], models: Record<string, RobotModel>): void {
    for (const info of robots) {
      const model = models[info.name];
      if (!model || this.robots.get(info.name)?.model === model) continue;
      this.remove(info.name);
      const figure = new RobotFigure(model, this.come);
      place(figure.root, info.base);
      figure.tcp.add(axes(0.06));
      this.robots.set(info.name, figure);
      const group = new THREE.Group();
      const spot = new THREE.Group().add(this.stage.floor.addSpot(new THREE.Vector3(0, 0, 0.0008), footOf(model)));
      place(spot, info.base);
      group.add(figure.root, spot);
      this.grounds.set(info.name, { group, base: info.base });
      this.stage.scene.add(group);
      const trail = new Trail();
      this.trails.set(info.name, trail);
      this.stage.scene.add(trail.line);
      const first = Object.fromEntries(info.joints.map((joint) => [joint.name, 0]));
      figure.setJoints((name) => first[name] ?? 0);
    }
    for (const name of this.robots.keys()) if (!robots.some((info) => info.name === name)) this.remove(name);
    this.redraw();
  }

  private remove(name: string): void {
    const ground = this.grounds.get(name)?.group;
    for (const object of [this.overlay.group, this.frames]) if (object.parent === ground) this.stage.scene.add(object);
    for (const object of [ground, this.trails.get(name)?.line]) {
      if (object) dispose(object);
      object?.removeFromParent();
    }
    this.paths.delete(name);
    this.robots.delete(name);
    this.grounds.delete(name);
    const sign = this.signs.get(name);
    if (sign) empty(sign);
    this.signs.delete(name);
    this.ghosts.delete(name);
    this.trails.delete(name);
  }

  setScene(scene: SceneInfo): void {
    for (const group of [this.things, this.zones]) {
      dispose(group);
      group.clear();
    }
    empty(this.names);
    this.moving.clear();
    this.carried.length = 0;
    for (const thing of scene.things) {
      const object = this.thing(thing);
      if (thing.moving) this.moving.set(thing.name, object);
      else if (thing.kind === 'fixture') this.names.add(nameOf(object));
      const mover = scene.movers.find((each) => each.name === thing.mover);
      if (mover) this.carried.push({ object, home: object.position.clone(), axis: new THREE.Vector3(...mover.axis), field: mover.field });
    }
    this.floor = scene.floor ?? 0;
    this.stage.setFloor(this.floor, this.dark);
    if (this.framed && !this.stage.touched) this.fit(this.stage.view);
    this.redraw();
  }

  /** Shows points of a page's list and highlights the selected ones. */
  setPoints(points: readonly NamedPose[], chosen: readonly string[]): void {
    this.overlay.setPoints(points, chosen);
    this.redraw();
  }

  setDryRun(paths: readonly DryPath[], problems: readonly DryProblem[]): void {
    this.overlay.setDryRun(paths, problems);
    this.redraw();
  }

  /** Shows unexpected contacts: a red mark with names and depth, and both bodies in red. */
  setContacts(touches: readonly Touch[]): void {
    const bodies = new Map<string, THREE.Object3D>();
    for (const group of [this.things, this.zones]) for (const each of group.children) bodies.set(each.name, each);
    for (const [robot, figure] of this.robots) {
      figure.root.traverse((each) => each.name && bodies.set(`${robot}/${each.name}`, each));
      if (figure.tool.children.length > 0) bodies.set(`${robot}/tool`, figure.tool);
    }
    const heldBy = (robot: string) => this.held.get(robot);
    this.contacts.show(touches, (name) => bodies.get(nameInPicture(name, heldBy)));
    this.redraw();
  }

  /** Shows where robots are nearest to something. */
  setNear(nears: readonly Near[]): void {
    if (this.nearest.show(nears)) this.redraw();
  }

  /** Shows named frames. */
  setFrames(frames: ({ name: string } & Pose)[]): void {
    dispose(this.frames);
    this.frames.clear();
    for (const frame of frames) {
      const object = axes(0.05, 0.9);
      object.name = frame.name;
      place(object, frame);
      this.frames.add(object);
    }
    this.redraw();
  }

  /** Selects the robot whose points, frames and dry runs are shown, and whose TCP the handle drags. */
  setShown(robot: string): void {
    const ground = this.grounds.get(robot)?.group ?? this.stage.scene;
    for (const object of [this.overlay.group, this.frames, this.handle?.object]) if (object) ground.add(object);
    this.shown = robot;
    this.nameRobots();
    this.redraw();
  }

  /** Among several robots each has its name at its foot; that of the selected one stands out. */
  private nameRobots(): void {
    for (const [name, { group }] of this.grounds) {
      const sign = this.signs.get(name);
      if (sign) empty(sign);
      sign?.removeFromParent();
      this.signs.delete(name);
      if (this.grounds.size < 2) continue;
      const next = new THREE.Group().add(label(name, name === this.shown));
      next.position.copy(this.robots.get(name)!.root.position);
      this.signs.set(name, next);
      group.add(next);
    }
  }

  private thing(thing: SceneThing): THREE.Object3D {
    const object = new THREE.Group();
    object.name = thing.name;
    place(object, thing);
    const zone = kZoneKinds.includes(thing.kind) && !thing.moving;
    for (const visual of thing.visuals) object.add(shape(visual, this.come, true));
    (zone ? this.zones : this.things).add(object);
    return object;
  }

  setParts(parts: Record<string, PartPose>): void {
    this.held.clear();
    for (const part of Object.values(parts)) {
      if (part.heldBy) this.held.set(part.heldBy, part.name);
      const object = this.moving.get(part.name);
      if (!object) continue;
      place(object, part);
      object.visible = part.here;
    }
    this.redraw();
  }

  /**
   * Updates the poses, and extends the TCP's trail. `tcp` is given as if the base were at its initial pose;
   * `base`: its present pose.
   */
  update(robot: string, values: (joint: string) => number, tcp: Vec3 | null, base?: Pose): void {
    const figure = this.robots.get(robot);
    if (!figure) return;
    let seen = figure.setJoints(values);
    const ground = this.grounds.get(robot)!;
    const moved = base && compose(base, inverse(ground.base));
    if (moved && !stands(ground.group, moved)) {
      const before = figure.root.getWorldPosition(new THREE.Vector3());
      place(ground.group, moved);
      if (this.framed && robot === this.shown) this.stage.follow(figure.root.getWorldPosition(new THREE.Vector3()).sub(before));
      seen = true;
    }
    if (tcp && tcp.every(Number.isFinite)) {
      const at = moved ? compose(moved, { p: tcp, q: [0, 0, 0, 1] }).p : tcp;
      seen = this.trails.get(robot)?.add(at) || seen;
    }
    if (!this.framed) {
      this.framed = true;
      this.fit('free');
    }
    if (seen) this.redraw();
  }

  /** Moves the jaws of a robot's gripper; `width`: between the pads, m. */
  updateGripper(robot: string, width: number): void {
    if (this.robots.get(robot)?.setWidth(width)) this.redraw();
  }

  /** Moves objects on machine axes; the fields contain the positions of the axes. */
  updateMovers(values: (field: string) => number): void {
    for (const { object, home, axis, field } of this.carried) {
      const at = values(field);
      if (!Number.isFinite(at)) continue;
      const before = object.position.clone();
      if (object.position.copy(home).addScaledVector(axis, at).distanceToSquared(before) > 0) this.redraw();
    }
  }

  setLayers(layers: Layers): void {
    this.layers = layers;
    this.frames.visible = layers.frames;
    this.zones.visible = layers.zones;
    for (const each of this.things.children) if (!this.moving.has(each.name)) each.visible = layers.things;
    this.names.visible = layers.names && layers.things;
    this.nearest.group.visible = layers.near;
    for (const trail of this.trails.values()) trail.line.visible = layers.trail;
    for (const path of this.paths.values()) path.visible = layers.plan;
    for (const ghost of this.ghosts.values()) ghost.root.visible = layers.plan;
    this.redraw();
  }

  clearTrails(): void {
    for (const trail of this.trails.values()) trail.clear();
    this.redraw();
  }

  /** Shows the planned path, and the robot at its end; null removes them. */
  setPlan(robot: string, plan: Plan | null): void {
    const before = this.paths.get(robot);
    if (before) dispose(before);
    before?.removeFromParent();
    this.paths.delete(robot);
    if (plan?.path && plan.path.length > 1) {
      const form = new THREE.BufferGeometry().setFromPoints(plan.path.map((p) => new THREE.Vector3(...p)));
      const tints = plan.path.flatMap((_, i) => clearanceColor(plan.clear?.[i]).toArray());
      form.setAttribute('color', new THREE.Float32BufferAttribute(tints, 3));
      const line = new THREE.Line(form, new THREE.LineDashedMaterial({ vertexColors: true, dashSize: 0.012, gapSize: 0.008 }));
      line.computeLineDistances();
      line.visible = this.layers.plan;
      this.paths.set(robot, line);
      (this.grounds.get(robot)?.group ?? this.stage.scene).add(line);
    }
    this.redraw();
  }

  setGhost(robot: string, joints: Record<string, number> | null): void {
    const figure = this.robots.get(robot);
    if (!figure) return;
    let ghost = this.ghosts.get(robot);
    if (!joints) {
      ghost?.root.removeFromParent();
      this.redraw();
      return;
    }
    if (!ghost) {
      const painted: RobotFigure = new RobotFigure(figure.model, () => (painted.paint(this.ghostLook), this.redraw()));
      ghost = painted;
      ghost.paint(this.ghostLook);
      this.ghosts.set(robot, ghost);
    }
    ghost.root.position.copy(figure.root.position);
    ghost.root.quaternion.copy(figure.root.quaternion);
    ghost.setJoints((name) => joints[name] ?? 0);
    ghost.root.visible = this.layers.plan;
    this.grounds.get(robot)?.group.add(ghost.root);
    this.redraw();
  }

  /**
   * Shows a handle at a pose of the shown robot's TCP, which can be dragged along and about its axes; null
   * removes it.
   */
  setHandle(handle: Handle | null): void {
    if (!handle) {
      if (!this.handle) return;
      this.handle.controls.detach();
      this.handle.controls.getHelper().removeFromParent();
      this.handle.controls.dispose();
      this.handle.object.removeFromParent();
      this.handle = null;
      return this.redraw();
    }
    if (!this.handle) this.handle = this.makeHandle(handle);
    const { controls, object } = this.handle;
    this.handle.told = handle;
    controls.setMode(handle.turn ? 'rotate' : 'translate');
    controls.setSpace(handle.local ? 'local' : 'world');
    if (!controls.dragging) place(object, handle.pose);
    this.redraw();
  }

  private makeHandle(told: Handle) {
    const object = new THREE.Object3D();
    const controls = new TransformControls(this.stage.camera, this.stage.renderer.domElement);
    controls.setSize(0.85);
    controls.attach(object);
    (this.grounds.get(this.shown)?.group ?? this.stage.scene).add(object);
    this.stage.scene.add(controls.getHelper());
    const handle = { controls, object, told };
    controls.addEventListener('change', this.redraw);
    controls.addEventListener('dragging-changed', (event) => {
      this.stage.controls.enabled = !event.value;
      handle.told.onHold(event.value === true);
    });
    controls.addEventListener('objectChange', () => {
      const { x, y, z, w } = object.quaternion;
      handle.told.onDrag({ p: object.position.toArray(), q: [x, y, z, w] });
    });
    return handle;
  }

  get dragging(): boolean {
    return this.handle?.controls.dragging ?? false;
  }

  fit(view: ViewName): void {
    const box = new THREE.Box3();
    for (const figure of this.robots.values()) box.expandByObject(figure.root);
    for (const object of this.moving.values()) if (object.visible) box.expandByObject(object);
    for (const zone of this.zones.children) box.expandByObject(zone);
    this.stage.look(view, box);
  }

  end(): void {
    this.setHandle(null);
    for (const ghost of this.ghosts.values()) disposeAll(ghost.root);
    disposeAll(this.stage.scene);
    this.contacts.end();
    this.ghostLook.dispose();
    this.stage.end();
  }
}
