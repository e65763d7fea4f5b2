/** A robot as three.js objects: links are children of joints, and joints are moved by name. */
import * as THREE from 'three';
import type { ModelJoint, RobotModel, Visual } from '../wire/types';
import { jointPose, valueOfJoint } from './chain';
import { place, shape } from './shapes';

interface Turned {
  joint: ModelJoint;
  object: THREE.Object3D;
  value: number;
}
/** Smaller changes are not visible; rad, m. */
const kSeen = 1e-5;

export class RobotFigure {
  readonly root = new THREE.Group();
  readonly tcp = new THREE.Group();
  /** The tool's shapes, in the frame of their link. */
  readonly tool = new THREE.Group();
  private readonly turned: Turned[] = [];
  private readonly jaws: { object: THREE.Object3D; slide: THREE.Vector3 }[] = [];
  private width = NaN;

  constructor(
    readonly model: RobotModel,
    ready: () => void,
  ) {
    const links = new Map<string, THREE.Group>();
    const link = (name: string) => {
      let out = links.get(name);
      if (!out) {
        out = new THREE.Group();
        out.name = name;
        links.set(name, out);
      }
      return out;
    };
    this.root.add(link(model.root));
    for (const each of model.links) for (const visual of each.visuals) link(each.name).add(shape(visual, ready));
    for (const joint of model.joints) {
      const fixed = new THREE.Group();
      fixed.userData.joint = joint.name;
      const object = new THREE.Group();
      place(fixed, joint.origin);
      link(joint.parent).add(fixed.add(object.add(link(joint.child))));
      if (joint.type !== 'fixed') this.turned.push({ joint, object, value: NaN });
    }
    place(this.tcp, model.tcp);
    link(model.tcp.link).add(this.tcp);
    this.addTool(ready);
  }

  /** Adds the tool's shapes in the frame of their link or of the TCP's link. */
  private addTool(ready: () => void): void {
    const tool = this.model.tool as { visuals?: Visual[]; link?: string; stroke?: number } | undefined;
    if (!tool?.visuals) return;
    const on = this.root.getObjectByName(tool.link ?? this.model.tcp.link) ?? this.root;
    this.tool.userData.joint = 'tool';  // a body of its own, as links behind joints are
    on.add(this.tool);
    for (const visual of tool.visuals) {
      const object = shape(visual, ready);
      this.tool.add(visual.slide ? new THREE.Group().add(object) : object);
      if (visual.slide) this.jaws.push({ object: object.parent!, slide: new THREE.Vector3(...visual.slide) });
    }
    this.setWidth(tool.stroke ?? 0);
  }

  /** Moves the jaws of the gripper. `width`: between the pads, m; unknown values are ignored. Returns true if the change is visible. */
  setWidth(width: number): boolean {
    if (!Number.isFinite(width) || this.jaws.length === 0 || Math.abs(width - this.width) < kSeen) return false;
    this.width = width;
    for (const { object, slide } of this.jaws) object.position.copy(slide).multiplyScalar(width);
    return true;
  }

  /** Returns true if the change is visible. */
  setJoints(values: (name: string) => number): boolean {
    let seen = false;
    for (const turned of this.turned) {
      const value = valueOfJoint(turned.joint, values);
      if (Math.abs(value - turned.value) < kSeen) continue;
      turned.value = value;
      place(turned.object, jointPose(turned.joint, value));
      seen = true;
    }
    return seen;
  }

  /** Gives every mesh of the robot the same material; for the ghost. */
  paint(look: THREE.Material): void {
    this.root.traverse((each) => {
      if (!(each instanceof THREE.Mesh)) return;
      each.material = look;
      each.castShadow = each.receiveShadow = false;
    });
  }
}
