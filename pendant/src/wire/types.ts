/** What the server says, as the page reads it. Lengths in m, angles in rad, quaternions x y z w. */

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
  /** It stands ready, and was not started yet. */
  ready: boolean;
  /** Of what stands ready, to start that and nothing else; empty when it has begun. */
  hash: string;
  line: number;
  /** The statement at that line. */
  source: string;
  /** Of the outermost loop. */
  passes: number;
  /** The newest whole one, s of cell time; NaN before. */
  lastPass: number;
  /** Why it failed, with its place. */
  problem: string;
}

/** Two that touched and should not have; lengths in m, in the world. */
export interface Touch {
  a: string;
  b: string;
  depth: number;
  at: Vec3 | null;
  now: boolean;
  text: string;
}
export interface Contacts {
  /** False: nothing in this cell finds contacts. */
  checked: boolean;
  touching: boolean;
  /** Bodies whose contacts nothing finds: in the cell's own sentences, and by code. */
  unchecked: {code: string; what: string; facts: Facts}[];
  /** Newest last. */
  list: Touch[];
}

/** Why something cannot be done. */
export interface Why {
  code: string;
  what: string;
  advice?: string;
  facts?: Facts;
}

export interface Status {
  /** `no cell` between two cells. */
  state: RunState | 'no cell';
  cause: string;
  moving: boolean;
  /** Is there something of a motion that Resume would go on with? */
  motionLeft: boolean;
  armed: boolean;
  simulated: boolean;
  profile: string;
  /** The TCP is kept slow: by the profile, or as the first run after arming. */
  reduced: boolean;
  /** Percent of the planned speed that is asked, and that is allowed. */
  override: number;
  allowed: number;
  holder: Holder | null;
  youHold: boolean;
  clients: number;
  program: ProgramStatus | null;
  failure: string;
  /** Hardware that is not active. */
  inactive: string[];
  /** Why it does not run, in one word for programs; 'none' or '' where it runs. */
  causeCode: string;
  /** Values of that cause. */
  causeFacts: Facts;
  contacts: Contacts;
  /** What cannot be done now and why, by request (resume, discard, back …); what is not named can be. */
  cannot: Record<string, Why>;
  /** The same of jogging, by robot. */
  cannotJog: Record<string, Why>;
  /** Robots that somebody moves by hand. */
  jogged: string[];
}

export interface JointInfo {
  /** As in the model. */
  name: string;
  /** Before /position in names of fields. */
  interface: string;
  type: 'revolute' | 'continuous' | 'prismatic' | string;
  lower: number;
  upper: number;
  velocity: number;
  /** False for joints beside the way to the TCP. */
  moves_tcp?: boolean;
  unit: 'rad' | 'm' | string;
}

export interface RobotInfo {
  name: string;
  id: string;
  title: string;
  base: Pose;
  /** It has wheels that somebody can drive. */
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
  /** Name of the mover that carries it. */
  mover?: string;
}

export interface SceneInfo {
  /** Height of the floor; null where there is none. */
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
  /** False while it waits in a feeder or was taken away. */
  here: boolean;
  /** It was in the cell and an outfeed has taken it away. */
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
  over: boolean;
  /** Not over: what holds it back; over: why. */
  why: string;
  text: string;
  /** The joint or the zone that holds it back; '' where neither does. */
  which: string;
}
