/** The page's types for the server's messages. Lengths in m, angles in rad, quaternions x y z w. */

export type Vec3 = [number, number, number];
export type Quat = [number, number, number, number];
export interface Pose {
  p: Vec3;
  q: Quat;
}

/** Values of a sentence, by name; the name of a number ends with its unit. */
export type Facts = Record<string, string|number>;

export type RunState = 'running' | 'stopping' | 'held' | 'fault' | 'backing';
export type ProgramState = 'ready' | 'running' | 'waiting' | 'finished' | 'failed' | 'stopped';

export interface Holder {
  client: number;
  name: string;
}

export interface ProgramStatus {
  file: string;
  state: ProgramState;
  paused: boolean;
  ended: boolean;
  /** True if the program is loaded and has not been started. */
  ready: boolean;
  /** The hash of a program that is ready, so that Start runs this version only; empty after the start. */
  hash: string;
  line: number;
  /** The file of that line: that of the program, or one that it includes. */
  lineFile: string;
  /** The statement at that line. */
  source: string;
  /** Number of passes of the outermost loop. */
  passes: number;
  /** Duration of the last complete pass, s of cell time; NaN before the first. */
  lastPass: number;
  /** Why it failed, with the place. */
  problem: string;
}

/** An unexpected contact of two bodies; lengths in m, in the world. */
export interface Touch {
  a: string;
  b: string;
  depth: number;
  at: Vec3 | null;
  now: boolean;
  text: string;
}
export interface Contacts {
  /** False: nothing in this cell checks for contacts. */
  checked: boolean;
  touching: boolean;
  /** Bodies whose contacts are not checked: the cell's sentence and its code. */
  unchecked: {code: string; what: string; facts: Facts}[];
  /** Oldest first. */
  list: Touch[];
}

/** The reason why something is not possible. */
export interface Why {
  code: string;
  what: string;
  advice?: string;
  facts?: Facts;
}

export interface Status {
  /** `no cell` while a cell is replaced by another one. */
  state: RunState | 'no cell';
  cause: string;
  moving: boolean;
  /** True if Resume would continue a motion. */
  motionLeft: boolean;
  armed: boolean;
  simulated: boolean;
  profile: string;
  /** The TCP speed is reduced: by the profile, or in the first run after arming. */
  reduced: boolean;
  /** Requested and allowed percent of the planned speed. */
  override: number;
  allowed: number;
  holder: Holder | null;
  youHold: boolean;
  clients: number;
  program: ProgramStatus | null;
  failure: string;
  /** Hardware that is not active, and inactive controllers that could move a robot. */
  inactive: string[];
  /** The cause why it does not run, as a code; 'none' or '' while it runs. */
  causeCode: string;
  /** Values of that cause. */
  causeFacts: Facts;
  contacts: Contacts;
  /**
   * The requests that are not possible now, with the reason (resume, discard, back …). All others are
   * possible.
   */
  cannot: Record<string, Why>;
  /** The same for jogging, by robot. */
  cannotJog: Record<string, Why>;
  /** Robots that somebody jogs. */
  jogged: string[];
}

export interface JointInfo {
  /** The name in the model. */
  name: string;
  /** The prefix of the joint's fields, before /position. */
  interface: string;
  type: 'revolute' | 'continuous' | 'prismatic' | string;
  lower: number;
  upper: number;
  velocity: number;
  /** False for joints that do not move the TCP. */
  moves_tcp?: boolean;
  unit: 'rad' | 'm' | string;
}

export interface RobotInfo {
  name: string;
  id: string;
  title: string;
  base: Pose;
  /** True if it has wheels that can be jogged. */
  drives?: boolean;
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
  program?: string;
  scene: string;
}

export interface Visual {
  shape: 'capsule' | 'box' | 'cylinder' | 'sphere' | 'mesh' | 'boxes' | string;
  /** Box: the lengths of its sides. */
  size?: Vec3;
  /** 'boxes': six numbers each, the middle and the lengths of the sides. */
  boxes?: number[];
  radius?: number;
  length?: number;
  origin: Pose;
  color?: [number, number, number, number];
  /** One GLB file per robot. `node` contains the link's meshes, in the link's frame. */
  mesh?: string;
  node?: string;
  scale?: Vec3;
  /** A jaw of a gripper: how far it moves for each m between the pads. */
  slide?: Vec3;
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
  /** Name of the mover that carries it. */
  mover?: string;
  /** Of a part: the bin in which it should lie at the end; '' if the scene names none. */
  goalBin?: string;
  /** Of a part: a feeder brings it, so it has not begun in a bin. */
  fed?: boolean;
}

export interface SceneInfo {
  /** Height of the floor; null for a scene without a floor. */
  floor: number | null;
  things: SceneThing[];
  movers: { name: string; axis: Vec3; field: string }[];
}

export interface TagValue {
  value: unknown;
  text: string;
  quality: string;
  forced: boolean;
  by: string;
  since: number | null;
}

export interface PartPose extends Pose {
  name: string;
  /** False while it waits in a feeder or was removed. */
  here: boolean;
  /** True if an outfeed has removed it from the cell. */
  taken: boolean;
  /** The robot that holds it. */
  heldBy: string;
}

export interface LogLine {
  number: number;
  time: number;
  level: string;
  text: string;
  code?: string;
  facts?: Facts;
}

export interface Alarm {
  number: number;
  time: number;
  code: string;
  what: string;
  where: string;
  advice: string;
  facts: Facts;
  severity: 'error' | 'warning';
  /** Set by the page: the user has seen it. */
  seen?: boolean;
}

/** What is nearest to a robot, as its guard measures it. Lengths in m, in the world. */
export interface Near {
  /** The robot's body, and what is near it, as contacts name them: `arm/forearm_link`, `fixture table`. */
  a: string;
  b: string;
  distance: number;
  /** The distance that the guard keeps of them; NaN: none. */
  kept: number;
  onA: Vec3;
  onB: Vec3;
  /** How fast the guard lets a planned move go on, 0 to 1. */
  pace: number;
}

export interface Plan {
  robot: string;
  path: Vec3[] | null;
  /** For each place of the path: the distance of the robot from everything else, m; empty: not known yet. */
  clear?: number[];
  target: { joints: number[] | Record<string, number> } | null;
}

export interface JogEvent {
  robot: string;
  jog: number;
  over: boolean;
  /** During a motion: what holds it back. At its end: the reason. */
  why: string;
  text: string;
  /** The joint or the zone that holds it back; '' if neither does. */
  which: string;
}
