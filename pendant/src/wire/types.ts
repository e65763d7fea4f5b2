/** What the server says, as the page reads it. Lengths in m, angles in rad, quaternions x y z w. */

export type Vec3 = [number, number, number];
export type Quat = [number, number, number, number];
export interface Pose {
  p: Vec3;
  q: Quat;
}

export type RunState = 'running' | 'stopping' | 'held' | 'fault' | 'backing';
export type ProgramState = 'running' | 'waiting' | 'finished' | 'failed' | 'stopped';

export interface Holder {
  client: number;
  name: string;
}

export interface ProgramStatus {
  file: string;
  state: ProgramState;
  paused: boolean;
  line: number;
  passes: number;
  /** The last whole pass, s. */
  cycle_s: number | null;
  elapsed_s: number;
  tasks: number;
}

export interface Status {
  state: RunState;
  cause: string;
  reason: string;
  moving: boolean;
  armed: boolean;
  simulated: boolean;
  profile: string;
  /** Percent of the planned speed that is asked, and that is allowed. */
  override: number;
  allowed: number;
  holder: Holder | null;
  you_hold: boolean;
  clients: number;
  motion_held: boolean;
  program: ProgramStatus | null;
  alarms: number;
  time_s: number;
  robots: { name: string; base: Pose; jogging: number | null }[];
}

export interface JointInfo {
  name: string;
  type: 'revolute' | 'continuous' | 'prismatic' | string;
  lower: number;
  upper: number;
  velocity: number;
  unit: 'rad' | 'm' | string;
}

export interface RobotInfo {
  name: string;
  id: string;
  title: string;
  base: Pose;
  joints: JointInfo[];
  model: string;
}

export interface CellInfo {
  name: string;
  folder: string;
  simulated: boolean;
  real: boolean;
  rate_hz: number;
  robots: RobotInfo[];
  frames?: string[] | { name: string }[];
  scene: string;
}

export interface Visual {
  shape: 'capsule' | 'box' | 'cylinder' | 'sphere' | 'mesh' | string;
  /** Box: its three sides. */
  size?: Vec3;
  radius?: number;
  length?: number;
  origin: Pose;
  color?: [number, number, number, number];
  /** One GLB a robot; `node` in it holds the link's meshes, in the link's frame. */
  mesh?: string;
  node?: string;
  scale?: Vec3;
}

export interface ModelLink {
  name: string;
  visuals: Visual[];
}

export interface ModelJoint {
  name: string;
  type: string;
  parent: string;
  child: string;
  origin: Pose;
  axis: Vec3;
  mimic?: { joint: string; multiplier: number; offset: number } | null;
}

export interface RobotModel {
  root: string;
  links: ModelLink[];
  joints: ModelJoint[];
  tcp: Pose & { link: string };
  tool?: unknown;
}

export interface SceneThing {
  name: string;
  kind: string;
  p: Vec3;
  q: Quat;
  visuals: Visual[];
  moving?: boolean;
}

export interface SceneInfo {
  things: SceneThing[];
  frames: ({ name: string } & Pose)[];
}

export interface TagValue {
  value: unknown;
  quality: string;
  forced: boolean;
  by: string;
  since: number;
}

export interface PartPose extends Pose {
  name: string;
  held?: boolean;
  state?: string;
}

export interface LogLine {
  time: number;
  level: string;
  text: string;
}

export interface Alarm {
  time: number;
  code: string;
  what: string;
  where?: string;
  why?: string;
  advice?: string;
  /** Set by the page: has somebody seen it? */
  seen?: boolean;
}

export interface Plan {
  robot: string;
  path: Vec3[] | null;
  target: { joints: number[] | Record<string, number> } | null;
}

export interface JogEvent {
  robot: string;
  jog: number;
  ended: string | null;
  held_back: string;
  reason: string;
}
