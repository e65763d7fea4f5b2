/**
 * Made from polyarm/protocol by tests/protocol: arguments and answers of every request. Do not edit;
 * the test ReferenceTest.ThePageHasTheTypes with POLYARM_UPDATE=1 writes it anew.
 * Lengths in m, angles in rad, quaternions x y z w; a number that is NaN or infinite comes as null.
 */

export interface Asked {
  asked: string;
}

export interface BasePose {
  p: [number, number, number];
  q: [number, number, number, number];
}

export interface BreakpointList {
  breakpoints: FileLine[];
}

export interface Bucket {
  to_ns: number;
  count: number;
}

export interface CalibrateJointsAnswer {
  joints: JointError[];
  position_residuals: number[];
  rotation_residuals: number[];
  position_rms: number;
  rotation_rms: number;
  position_before: number;
  rotation_before: number;
  shift: number;
  turn: number;
  outlier?: number;
  file?: string;
}

export interface CalibratePayloadAnswer {
  mass: number;
  mass_sigma: number;
  center: [number, number, number];
  center_sigma: number;
  tool_mass: number;
  unit: string;
  residuals: number[];
  rms: number;
  outlier?: number;
  file?: string;
}

export interface CalibrateSampleAnswer {
  joints: Record<string, number>;
  flange: PoseFacts;
  measured?: PoseFacts;
  age?: number;
  force?: [number, number, number];
  torque?: [number, number, number];
  torques?: Record<string, number>;
  noise?: number;
}

export interface CalibrateUndoAnswer {
  key: string;
  robot: string;
}

export interface CellCheckAnswer {
  problems: Finding[];
  points: number;
  moves: number;
}

export interface CellConnectAnswer {
  real: boolean;
  hardware: RealHardware[];
  possible: boolean;
  why: string;
  advice: string;
  problem: ProblemFacts | null;
  asked?: string;
}

export interface CellReachAnswer {
  wants: WantedThing[];
  unread: string | null;
}

export interface CellStatus {
  event: string;
  cell: string;
  state: string;
  cause: string;
  cause_code: string;
  cause_facts: Record<string, string | number>;
  held: string;
  can: PossibleNow;
  contacts: ContactState;
  standing: boolean;
  motion_left: boolean;
  armed: boolean;
  needs_arming: boolean;
  simulated: boolean;
  profile: string;
  reduced: boolean;
  override: number;
  allowed: number;
  control: string;
  jogged: string[];
  program: ProgramOverview | null;
  plc: ProgramOverview | null;
  failure: string | null;
  alarms: number;
  inactive: string[];
  bases: Record<string, BasePose>;
  holder: ClientName | null;
  asker: ClientName | null;
  clients: number;
}

export interface CellsListAnswer {
  open: string;
  cells: KnownCell[];
}

export interface ChainLink {
  from: string;
  to: string;
  reference: string;
  active: boolean;
}

export interface ChangedPoint {
  name: string;
  kind: 'boolean' | 'number' | 'text' | 'list' | 'joints' | 'pose' | 'record';
  file: string;
  text: string;
  literal: string;
  value: unknown;
  unit: string;
  pose: PoseFacts | null;
  world: PoseFacts | null;
  joints: Record<string, number> | null;
  taught: TaughtFacts | null;
  group: string;
  undo: string;
}

export interface ChangedPoints {
  values: PointFacts[];
  undo: string;
}

export interface ClaimedCommand {
  name: string;
  claimed_by: string;
}

export interface ClampedCommand {
  interface: string;
  claimed_by: string;
  limit: string;
  count: number;
  asked: number | null;
  given: number | null;
  time_s: number;
}

export interface ClientName {
  client: number;
  name: string;
}

export interface CommandValue {
  name: string;
  value: number | null;
  claimed_by: string;
}

export interface ContactState {
  checked: boolean;
  stop: number | null;
  touching: boolean;
  unchecked: string[];
  unchecked_why: UncheckedBody[];
  list: Touch[];
}

export interface ControlArmAnswer {
  armed: boolean;
  joints?: ExpectedJoint[];
  started?: string[];
}

export interface ControlBackAnswer {
  asked: string;
  state: string;
  joints: Record<string, number>;
}

export interface ControlDiscardAnswer {
  asked: string;
  discarded: boolean;
  next: string;
}

export interface ControlHolder {
  you_hold: boolean;
  holder: ClientName | null;
}

export interface ControlLoadAnswer {
  name: string;
  state: string;
  warnings: string[];
}

export interface ControlOverrideAnswer {
  asked: string;
  percent: number;
  allowed: number;
}

export interface ControlStateAnswer {
  name: string;
  state: string;
  ok?: boolean;
  reason?: string;
  advice?: string;
  start?: string[];
  stop?: string[];
  left_out?: string[];
  chained?: string[];
  unchained?: string[];
}

export interface ControlStopAnswer {
  asked: string;
  category: number;
  inactive?: string[];
}

export interface ControllerInput {
  name: string;
  types: string[];
}

export interface ControllerTypeText {
  type: string;
  text: string;
}

export interface DeviceFacts {
  parameter: string;
  path: string;
  there: boolean;
}

export interface Distribution {
  p50_ns: number;
  p99_ns: number;
  max_ns: number;
  buckets: Bucket[];
}

export interface Event {
  number: number;
  event: string;
  time_s?: number;
  text?: string;
  task?: string;
  file?: string;
  line?: number;
  source?: string;
  name?: string;
  value?: string;
  by?: string;
  state?: string;
  cause?: string;
  cause_code?: string;
  code?: string;
  where?: string;
  what?: string;
  advice?: string;
  severity?: 'error' | 'warning';
  at_s?: number;
  category?: number;
  tcp_m?: Record<string, number>;
  joints?: Record<string, number>;
}

export interface ExpectedJoint {
  joint: string;
  measured: number | null;
  expected: number | null;
}

export interface FailedComponent {
  component: string;
  cause: string;
  cause_code: string;
  controllers: string[];
}

export interface FileDraft {
  text: string;
  base: string;
  by: string;
  saved_s: number;
}

export interface FileLine {
  file: string;
  line: number;
}

export interface FileVersion {
  number: number;
  when: string;
  what: string;
  bytes: number;
}

export interface FilesDraftAnswer {
  saved_s: number;
}

export interface FilesListAnswer {
  folder: string;
  files: ListedFile[];
  main: string | null;
}

export interface FilesReadAnswer {
  name: string;
  text: string;
  hash: string;
  running: boolean;
  draft: FileDraft | null;
}

export interface FilesVersionAnswer {
  name: string;
  number: number;
  text: string;
}

export interface FilesVersionsAnswer {
  name: string;
  versions: FileVersion[];
}

export interface FilesWriteAnswer {
  name: string;
  hash: string;
}

export interface Finding {
  code: string;
  severity: 'error' | 'warning';
  file: string;
  line: number;
  column: number;
  what: string;
  advice: string;
  facts?: Record<string, string | number>;
}

export interface FunctionText {
  name: string;
  signature: string;
  meaning: string;
  in_tests: boolean;
}

export interface HardwareRecoverAnswer {
  name: string;
  state: string;
  fallen: string[];
  started?: string[];
  next: string;
}

export interface HardwareReloadAnswer {
  name: string;
  state: string;
  stopped: string[];
  warnings: string[];
  next: string;
}

export interface HardwareStateAnswer {
  name: string;
  state: string;
  stopped: string[];
  with?: string[];
}

export interface HelpArgument {
  name: string;
  type: string;
  needed: boolean;
}

export interface HelpRow {
  request: string;
  arguments: HelpArgument[];
  result: string;
  text: string;
  moves: boolean;
}

export interface InterfacesListAnswer {
  states: StateValue[];
  commands: CommandValue[];
}

export interface JogAnswer {
  robot: string;
  model: string;
  tool: string;
  names: string[];
  slides: boolean[];
  joints: Record<string, number>;
  limits: Record<string, [number, number] | null>;
  position: [number, number, number];
  rpy: [number, number, number];
  orientation: [number, number, number, number];
  speed: number;
  moving: boolean;
  held_back: string;
  reason: string;
  which: string;
  profile: string;
  control: string;
  session?: number;
  done?: boolean;
}

export interface JogBegun {
  jog: number;
  session: number;
  beat_s: number;
  silence_s: number;
}

export interface JogEvent {
  event: string;
  jog: number;
  robot: string;
  over: boolean;
  why: string;
  text: string;
  which: string;
}

export interface JointError {
  joint: string;
  offset: number;
  sigma: number;
  identifiable: boolean;
}

export interface JustName {
  name: string;
}

export interface KnownCell {
  name: string;
  folder: string;
  title: string;
  robots: string[];
  recent: boolean;
}

export interface KnownName {
  name: string;
  kind: string;
  text: string;
}

export interface LanguageWordsAnswer {
  words: WordText[];
  functions: FunctionText[];
}

export interface LimitsProfileAnswer {
  profile: string;
  joint_speed: number;
  tcp_speed: number | null;
}

export interface LinkState {
  name: string;
  address: string;
  up: boolean;
  reason: string;
  losses: number;
  exchanges: number;
  round_ms: number;
  on_loss: string;
  tags: number;
}

export interface ListedController {
  name: string;
  type: string;
  state: string;
  chained: boolean;
  async: boolean;
  stale: boolean;
  rate: number;
  updates: number;
  missed: number;
  claimed: string[];
  commands: string[];
  states: string[];
  references: string[];
  exported_states: string[];
  fallback: string[];
  inputs: ControllerInput[];
}

export interface ListedFile {
  name: string;
  kind: string;
  bytes: number;
  modified_s: number;
  hash: string;
  running: boolean;
  draft: boolean;
}

export interface ListedHardware {
  name: string;
  type: string;
  plugin: string;
  group: string;
  state: string;
  being: string;
  rate: number;
  async: boolean;
  missed: number;
  states: string[];
  commands: ClaimedCommand[];
}

export interface LoopHealthAnswer {
  state: string;
  cause: string;
  cause_code: string;
  standing: boolean;
  time_s: number;
  rate_hz: number;
  cycles: number;
  late: number;
  cost: Distribution;
  wake_up: Distribution;
  period: Distribution;
  clamps: number;
  override_percent: number;
  allowed_percent: number;
  last_stop: StopFacts | null;
  parts: LoopPart[];
  threads: PartThread[];
  fallen: FailedComponent[];
}

export interface LoopPart {
  component?: string;
  controller?: string;
  rate_hz: number;
  turns: number;
  cost: Times;
  period: Times;
}

export interface MeshFacts {
  size: [number, number, number];
  lower: [number, number, number];
  triangles: number;
  metres: boolean;
  likely: string;
}

export interface MoveToAnswer {
  robot: string;
  cell: string;
  cause: string;
  elapsed_s: number;
  left_s: number | null;
  left_m: number | null;
  done?: boolean;
}

export interface NameAndFolder {
  name: string;
  folder: string;
}

export interface NameAndState {
  name: string;
  state: string;
}

export interface NamedText {
  name: string;
  value: string;
}

export interface NoCellStatus {
  event: string;
  state: string;
  cell: string | null;
  holder: ClientName | null;
  asker: ClientName | null;
  clients: number;
}

export interface NoMessage {
  waiting: string;
  state: string;
  what: string;
  advice: string;
}

export interface Nothing {
}

export interface OutsideChanges {
  files: OutsideFile[];
}

export interface OutsideFile {
  file: string;
  changed: string[];
  added: string[];
  removed: string[];
}

export interface ParamSetAnswer {
  changed: number;
}

export interface Parameter {
  key: string;
  type: string;
  value: string;
  default: string;
  changeable: boolean;
  text: string;
  choices?: string[];
}

export interface PartThread {
  component?: string;
  controller?: string;
  rate_hz: number;
  own_clock: boolean;
  runs: number;
  late: number;
  missed: number;
  cost: Times;
  wake_up: Times;
  period: Times;
}

export interface PastChange {
  number: number;
  when: string;
  what: string;
}

export interface PlanPreviewAnswer {
  ok: boolean;
  reason: string;
  robot: string;
  path: ([number, number, number])[];
  seconds: number;
  joints: Record<string, number>;
  pose: PoseFacts;
  warnings: string[];
}

export interface PointFacts {
  name: string;
  kind: 'boolean' | 'number' | 'text' | 'list' | 'joints' | 'pose' | 'record';
  file: string;
  text: string;
  literal: string;
  value: unknown;
  unit: string;
  pose: PoseFacts | null;
  world: PoseFacts | null;
  joints: Record<string, number> | null;
  taught: TaughtFacts | null;
  group: string;
}

export interface PointsCameraAnswer {
  kind?: 'boolean' | 'number' | 'text' | 'list' | 'joints' | 'pose' | 'record';
  file?: string;
  text?: string;
  literal?: string;
  value?: unknown;
  unit?: string;
  pose?: PoseFacts | null;
  world?: PoseFacts | null;
  joints?: Record<string, number> | null;
  taught?: TaughtFacts | null;
  group?: string;
  undo?: string;
  name: string;
  frame: string;
  camera: PoseFacts;
  marker: PoseFacts;
  position_residuals: number[];
  rotation_residuals: number[];
  position_rms: number;
  rotation_rms: number;
  position_sigma: number;
  rotation_sigma: number;
  outlier?: number;
  next: PoseFacts;
  next_sigma: number;
}

export interface PointsDeleteAnswer {
  name: string;
  undo: string;
}

export interface PointsFrameAnswer {
  kind?: 'boolean' | 'number' | 'text' | 'list' | 'joints' | 'pose' | 'record';
  file?: string;
  text?: string;
  literal?: string;
  value?: unknown;
  unit?: string;
  world?: PoseFacts | null;
  joints?: Record<string, number> | null;
  taught?: TaughtFacts | null;
  group?: string;
  undo?: string;
  name: string;
  pose: PoseFacts;
  frame: string;
  angle: number;
  x_length: number;
  y_length: number;
}

export interface PointsHereAnswer {
  robot: string;
  tcp: PoseFacts;
  flange: PoseFacts;
  joints: Record<string, number>;
  tool: string;
}

export interface PointsListAnswer {
  file: string;
  files: string[];
  values: PointFacts[];
}

export interface PointsRenameAnswer {
  name: string;
  kind: 'boolean' | 'number' | 'text' | 'list' | 'joints' | 'pose' | 'record';
  file: string;
  text: string;
  literal: string;
  value: unknown;
  unit: string;
  pose: PoseFacts | null;
  world: PoseFacts | null;
  joints: Record<string, number> | null;
  taught: TaughtFacts | null;
  group: string;
  undo: string;
  uses: FileLine[];
}

export interface PointsSightingAnswer {
  flange: PoseFacts;
  marker: PoseFacts;
  age: number;
}

export interface PointsToolAnswer {
  kind?: 'boolean' | 'number' | 'text' | 'list' | 'joints' | 'pose' | 'record';
  file?: string;
  text?: string;
  literal?: string;
  value?: unknown;
  unit?: string;
  pose?: PoseFacts | null;
  world?: PoseFacts | null;
  joints?: Record<string, number> | null;
  taught?: TaughtFacts | null;
  group?: string;
  undo?: string;
  name: string;
  tcp: [number, number, number];
  tip: [number, number, number];
  residuals: number[];
  rms: number;
  largest: number;
  sigma: number;
  outlier?: number;
  next: PoseFacts;
  next_sigma: number;
}

export interface PointsUndoAnswer {
  what: string;
}

export interface PoseFacts {
  p: [number, number, number];
  q: [number, number, number, number];
  rpy: [number, number, number];
}

export interface PossibleNow {
  resume: ProblemFacts | null;
  discard: ProblemFacts | null;
  back: ProblemFacts | null;
  recover: ProblemFacts | null;
  program: ProblemFacts | null;
  jog: Record<string, ProblemFacts | null>;
}

export interface ProblemFacts {
  code: string;
  what: string;
  advice: string;
  where: string;
  facts?: Record<string, string | number>;
}

export interface ProgramCheckAnswer {
  problems: Finding[];
}

export interface ProgramDryAnswer {
  problems: Finding[];
  moves: number;
  reached: FileLine | null;
  paths: RehearsedWay[];
  seconds: number | null;
  contacts: RehearsedContacts;
}

export interface ProgramFromAnswer {
  where: FileLine;
  source: string;
  robot: string;
  tool: string;
  frame: string;
  last_point: string;
  sets: NamedText[];
  reads: NamedText[];
  variables: NamedText[];
  held: string[];
  next?: string;
}

export interface ProgramLoadAnswer {
  state: string;
  file: string;
  name: string;
  hash: string;
  paused: boolean;
  ended: boolean;
  where: FileLine;
  source: string;
  sentence: string;
  passes: number;
  last_pass_s: number | null;
  problem: ProblemFacts | null;
  control: string;
  cause: string;
  holder: string;
  folder: string;
  robots: string[];
  held: string[];
  events: number;
  breakpoints: FileLine[];
  question: string | null;
  tasks: TaskFacts[];
  warnings: string[];
}

export interface ProgramNamesAnswer {
  names: KnownName[];
  version: number;
}

export interface ProgramOverview {
  state: string;
  file: string;
  name: string;
  hash: string;
  paused: boolean;
  ended: boolean;
  where: FileLine;
  source: string;
  sentence: string;
  passes: number;
  last_pass_s: number | null;
  problem: ProblemFacts | null;
}

export interface ProgramStateAnswer {
  state: string;
  file: string;
  name: string;
  hash: string;
  paused: boolean;
  ended: boolean;
  where: FileLine;
  source: string;
  sentence: string;
  passes: number;
  last_pass_s: number | null;
  problem: ProblemFacts | null;
  control: string;
  cause: string;
  holder: string;
  folder: string;
  robots: string[];
  held: string[];
  events: number;
  breakpoints: FileLine[];
  question: string | null;
  tasks: TaskFacts[];
  data?: Record<string, string>;
}

export interface ProgramStatus {
  state: string;
  file: string;
  name: string;
  hash: string;
  paused: boolean;
  ended: boolean;
  where: FileLine;
  source: string;
  sentence: string;
  passes: number;
  last_pass_s: number | null;
  problem: ProblemFacts | null;
  control: string;
  cause: string;
  holder: string;
  folder: string;
  robots: string[];
  held: string[];
  events: number;
  breakpoints: FileLine[];
  question: string | null;
  tasks: TaskFacts[];
}

export interface ProgramStepsAnswer {
  steps: StatementFacts[];
  problems: Finding[];
}

export interface QueryTrajectoryAnswer {
  joints: string[];
  found: boolean;
  position: number[];
  velocity: number[];
  acceleration: number[];
}

export interface RealHardware {
  robot: string;
  component: string;
  driver: string;
  drives: string;
  devices: DeviceFacts[];
}

export interface RecordFacts {
  recording: boolean;
  file: string;
  seconds: number;
  rate: number;
  messages: number;
  bytes: number;
  lost: number;
  problem: string;
}

export interface RehearsedContacts {
  checked: boolean;
  unchecked: string[];
  seconds: number;
  whole: boolean;
}

export interface RehearsedWay {
  robot: string;
  line: number;
  seconds: number;
  points: ([number, number, number])[];
}

export interface SceneAddAnswer {
  file: string;
  text: string;
}

export interface SceneUploadAnswer {
  bytes: number;
  file: string;
  mesh: MeshFacts | null;
}

export interface SendMessageAnswer {
  to?: string;
  goal?: number;
  status?: string;
  error_code?: number;
  error?: string;
  joint?: string;
  off_by?: number;
  tolerance?: number;
  note?: string;
  position?: number;
  effort?: number;
  stalled?: boolean;
  reached_goal?: boolean;
  feedback?: unknown;
}

export interface SessionHelloAnswer {
  client: number;
  holder: ClientName | null;
  you_hold: boolean;
  version: string;
  token_ok: boolean;
  cell: string | null;
  local: boolean;
  role: 'watch' | 'operate' | 'program' | 'administer';
}

export interface SessionTakeAnswer {
  you_hold: boolean;
  holder: ClientName | null;
  seconds: number;
}

export interface SessionWatchAnswer {
  rate: number;
}

export interface StateValue {
  name: string;
  value: number | null;
}

export interface StatementFacts {
  kind: string;
  line: number;
  end: number;
  depth: number;
  text: string;
  name: string;
  points: string[];
}

export interface StopFacts {
  at_s: number;
  time_s: number;
  category: number;
  cause: string;
  cause_code: string;
  tcp_m: Record<string, number>;
  joints: Record<string, number>;
}

export interface SwitchOutcome {
  ok: boolean;
  reason: string;
  advice: string;
  start: string[];
  stop: string[];
  left_out: string[];
  chained: string[];
  unchained: string[];
}

export interface TagChange {
  number: number;
  name: string;
  old: string | null;
  now: string | null;
  by: string;
}

export interface TagRules {
  on_stop?: unknown;
  on_hold?: unknown;
  on_link_loss?: unknown;
}

export interface TagState {
  name: string;
  type: string;
  unit: string;
  value: unknown;
  text: string;
  direction: string;
  source: string;
  quality: string;
  forced: boolean;
  tag: boolean;
  changed_s: number | null;
  changed_by: string;
  output: number | null;
  rules: TagRules;
}

export interface TagsHistoryAnswer {
  last: number;
  changes: TagChange[];
}

export interface TagsListAnswer {
  tags: TagState[];
  links: LinkState[];
}

export interface TaskFacts {
  name: string;
  state: string;
  where: FileLine;
  source: string;
  waits_for: string;
  names: string[];
  text: string;
  passes: number;
  paused: boolean;
  calls: FileLine[];
  variables: NamedText[];
  robot: string;
  tool: string;
  frame: string;
  problem?: string;
}

export interface TaughtFacts {
  frame: string;
  tool: string;
  robot: string;
}

export interface TeleopAnswer {
  pairs: TeleopPair[];
}

export interface TeleopPair {
  name: string;
  leader: string;
  follower: string;
  mapping: string;
  clutch: string;
  state: string;
  reason: string;
  furthest: string;
  distance: number;
}

export interface Times {
  p50_ns: number;
  p99_ns: number;
  max_ns: number;
}

export interface Touch {
  a: string;
  b: string;
  robot: string;
  at_s: number;
  depth: number;
  position: [number, number, number];
  now: boolean;
  doing: string;
  where: string;
  text: string;
}

export interface UncheckedBody {
  code: string;
  facts: Record<string, string | number>;
}

export interface WantedThing {
  kind: string;
  what: string;
  why: string;
  sha256: string;
  allowed: boolean;
}

export interface WordText {
  name: string;
  role: string;
  form: string;
  meaning: string;
  in_tests: boolean;
}

export interface Requests {
  'help': { args: {}; answer: HelpRow[] };
  'control.list': { args: {}; answer: ListedController[] };
  'control.types': { args: {}; answer: ControllerTypeText[] };
  'control.chains': { args: {}; answer: ChainLink[] };
  'control.switch': { args: { activate?: string | string[]; deactivate?: string | string[]; strictness?: 'strict' | 'best_effort' | 'best-effort' | 'auto' | 'force' | 'force_auto'; dry?: boolean }; answer: SwitchOutcome };
  'control.load': { args: { name: string; type?: string; file?: string; parameters?: Record<string, unknown> }; answer: ControlLoadAnswer };
  'control.configure': { args: { name: string }; answer: NameAndState };
  'control.cleanup': { args: { name: string }; answer: NameAndState };
  'control.unload': { args: { name: string }; answer: JustName };
  'control.state': { args: { name: string; state: string }; answer: ControlStateAnswer };
  'control.hold': { args: {}; answer: Asked };
  'control.stop': { args: { category?: number }; answer: ControlStopAnswer };
  'control.resume': { args: { anyway?: boolean }; answer: Asked };
  'control.back': { args: { time?: number; distance?: number }; answer: ControlBackAnswer };
  'control.override': { args: { percent?: number }; answer: ControlOverrideAnswer };
  'control.discard': { args: {}; answer: ControlDiscardAnswer };
  'contacts': { args: {}; answer: ContactState };
  'control.recover': { args: {}; answer: Asked };
  'tags.list': { args: { names?: string | string[] }; answer: TagsListAnswer };
  'tags.set': { args: { name: string; value: unknown; by?: string }; answer: TagState };
  'tags.force': { args: { name: string; value: unknown; by?: string }; answer: TagState };
  'tags.release': { args: { name: string; by?: string }; answer: TagState };
  'tags.history': { args: { names?: string | string[]; after?: number }; answer: TagsHistoryAnswer };
  'control.arm': { args: { confirmed?: boolean }; answer: ControlArmAnswer };
  'hardware.list': { args: {}; answer: ListedHardware[] };
  'hardware.state': { args: { name: string; state: string }; answer: HardwareStateAnswer };
  'hardware.recover': { args: { name?: string; controllers?: boolean }; answer: HardwareRecoverAnswer };
  'hardware.reload': { args: { name: string }; answer: HardwareReloadAnswer };
  'interfaces': { args: {}; answer: InterfacesListAnswer };
  'health': { args: {}; answer: LoopHealthAnswer };
  'limits': { args: {}; answer: ClampedCommand[] };
  'param.list': { args: { name: string }; answer: Parameter[] };
  'param.get': { args: { name: string; key: string }; answer: Parameter };
  'param.set': { args: { name: string; values: Record<string, unknown> }; answer: ParamSetAnswer };
  'send': { args: { to: string; message: unknown; goal?: boolean }; answer: SendMessageAnswer };
  'goal.cancel': { args: { to: string; goal: number }; answer: Asked };
  'query': { args: { name: string; at?: number }; answer: QueryTrajectoryAnswer };
  'watch': { args: { name: string; rate?: number; patience?: number }; answer: unknown | NoMessage };
  'jog': { args: { robot?: string; joints?: Record<string, unknown>; tcp?: Record<string, unknown>; frame?: string; by?: boolean; speed?: number; hold?: number; session?: number; end?: boolean }; answer: JogAnswer };
  'jog.state': { args: { robot?: string }; answer: JogAnswer };
  'target': { args: { robot?: string; joints?: Record<string, unknown>; pose?: Record<string, unknown>; frame?: string; speed?: number; hold?: number; session?: number }; answer: JogAnswer };
  'teleop': { args: { pair?: string; hold?: number }; answer: TeleopAnswer };
  'profile': { args: { name?: string }; answer: LimitsProfileAnswer };
  'move': { args: { points: unknown; robot?: string; kind?: 'joint' | 'line'; pace?: number; speed?: number; rests?: boolean }; answer: MoveToAnswer };
  'events': { args: { since?: number }; answer: Event[] };
  'program.load': { args: { file: string }; answer: ProgramLoadAnswer };
  'program.start': { args: { passes?: number; paused?: boolean; as_saved?: boolean; file?: string; hash?: string; saved?: string }; answer: ProgramStatus };
  'program.answer': { args: { text?: string; question?: string }; answer: Asked };
  'program': { args: { data?: boolean }; answer: ProgramStateAnswer };
  'program.watch': { args: { rate?: number }; answer: ProgramStatus };
  'program.pause': { args: { at_once?: boolean }; answer: ProgramStatus };
  'program.go': { args: {}; answer: ProgramStatus };
  'program.step': { args: { how?: 'into' | 'over' | 'out'; at_once?: boolean }; answer: ProgramStatus };
  'program.break': { args: { at?: string | string[]; off?: string | string[]; clear?: boolean; text?: string }; answer: BreakpointList };
  'program.edited': { args: { name: string; text: string; lines?: unknown }; answer: BreakpointList };
  'program.from': { args: { line?: number; program?: string; confirmed?: boolean; hash?: string }; answer: ProgramFromAnswer };
  'program.stop': { args: {}; answer: ProgramStatus };
  'points': { args: {}; answer: PointsListAnswer };
  'points.here': { args: { robot?: string }; answer: PointsHereAnswer };
  'points.teach': { args: { name: string; robot?: string; kind?: 'pose' | 'joints'; frame?: string; file?: string; group?: string; replace?: boolean }; answer: ChangedPoint };
  'points.set': { args: { name: string; value: string; frame?: string; file?: string }; answer: ChangedPoint };
  'points.shift': { args: { names: string | string[]; by: Record<string, unknown>; along?: 'frame' | 'own' }; answer: ChangedPoints };
  'points.group': { args: { names: string | string[]; group: string }; answer: ChangedPoints };
  'points.rename': { args: { name: string; to: string }; answer: PointsRenameAnswer };
  'points.delete': { args: { name: string }; answer: PointsDeleteAnswer };
  'points.outside': { args: {}; answer: OutsideChanges };
  'points.take': { args: {}; answer: OutsideChanges };
  'points.history': { args: { file?: string }; answer: PastChange[] };
  'points.undo': { args: { file?: string; steps?: number }; answer: PointsUndoAnswer };
  'points.frame': { args: { name: string; origin?: unknown; on_x?: unknown; in_plane?: unknown; from?: string | string[]; file?: string; dry?: boolean }; answer: PointsFrameAnswer };
  'points.tool': { args: { name: string; poses?: unknown; from?: string | string[]; robot?: string; file?: string; dry?: boolean }; answer: PointsToolAnswer };
  'points.sighting': { args: { marker: string; robot?: string }; answer: PointsSightingAnswer };
  'points.camera': { args: { name: string; sightings?: unknown; place?: 'hand' | 'beside'; robot?: string; file?: string; dry?: boolean }; answer: PointsCameraAnswer };
  'plan.preview': { args: { to?: string; joints?: Record<string, unknown>; pose?: Record<string, unknown>; kind?: 'joint' | 'line'; robot?: string; speed?: number }; answer: PlanPreviewAnswer };
  'calibrate.sample': { args: { robot?: string; marker?: string; forces?: boolean }; answer: CalibrateSampleAnswer };
  'calibrate.joints': { args: { samples: unknown; robot?: string; positions?: boolean; in_base?: boolean; of_flange?: boolean; check?: boolean; dry?: boolean }; answer: CalibrateJointsAnswer };
  'calibrate.payload': { args: { samples: unknown; robot?: string; check?: boolean; dry?: boolean }; answer: CalibratePayloadAnswer };
  'calibrate.undo': { args: {}; answer: CalibrateUndoAnswer };
  'files': { args: {}; answer: FilesListAnswer };
  'files.read': { args: { name: string }; answer: FilesReadAnswer };
  'files.draft': { args: { name: string; text?: string; base?: string; by?: string }; answer: FilesDraftAnswer };
  'files.write': { args: { name: string; text: string; base?: string; force?: boolean }; answer: FilesWriteAnswer };
  'files.versions': { args: { name: string }; answer: FilesVersionsAnswer };
  'files.version': { args: { name: string; number: number }; answer: FilesVersionAnswer };
  'files.delete': { args: { name: string }; answer: JustName };
  'files.rename': { args: { name: string; to: string }; answer: JustName };
  'scene.upload': { args: { name: string; offset: number; data: string; last?: boolean }; answer: SceneUploadAnswer };
  'scene.add': { args: { name: string; file: string; unit: string; at: [number, number, number]; rpy: [number, number, number]; scale?: number; mass?: number }; answer: SceneAddAnswer };
  'language.words': { args: {}; answer: LanguageWordsAnswer };
  'program.check': { args: { name: string; text?: string }; answer: ProgramCheckAnswer };
  'program.steps': { args: { name: string; text?: string }; answer: ProgramStepsAnswer };
  'program.names': { args: {}; answer: ProgramNamesAnswer };
  'cell.restart': { args: { robot?: string; hardware?: string; program?: string; cell?: string }; answer: Asked };
  'program.dry': { args: { name: string; text?: string }; answer: ProgramDryAnswer };
  'cell.check': { args: {}; answer: CellCheckAnswer };
  'cell.reach': { args: { folder?: string; allow?: string | string[] }; answer: CellReachAnswer };
  'cells': { args: {}; answer: CellsListAnswer };
  'cell.save_as': { args: { name: string }; answer: NameAndFolder };
  'cell.new': { args: { name: string; robot: string }; answer: NameAndFolder };
  'cell.connect': { args: { real?: boolean }; answer: CellConnectAnswer };
  'record': { args: {}; answer: RecordFacts };
  'record.start': { args: { file?: string; rate?: number }; answer: RecordFacts };
  'record.stop': { args: {}; answer: RecordFacts };
  'session.hello': { args: { name?: string }; answer: SessionHelloAnswer };
  'session.watch': { args: { rate?: number }; answer: SessionWatchAnswer };
  'session.end': { args: { of?: unknown }; answer: Nothing };
  'session.take': { args: { force?: boolean }; answer: SessionTakeAnswer };
  'session.release': { args: {}; answer: ControlHolder };
  'session.answer': { args: { give?: boolean }; answer: ControlHolder };
  'jog.begin': { args: { robot?: string; mode?: string; frame?: string; axis: unknown; direction?: number; speed?: number }; answer: JogBegun };
  'jog.beat': { args: { jog?: unknown }; answer: Nothing };
  'jog.end': { args: { jog?: number }; answer: Nothing };
  'jog.goto': { args: { robot?: string; to?: string; joints?: Record<string, unknown>; pose?: Record<string, unknown>; kind?: 'joint' | 'line'; speed?: number; dry?: boolean }; answer: JogBegun | PlanPreviewAnswer };
  'jog.step': { args: { robot?: string; mode?: string; frame?: string; axis: unknown; direction?: number; amount?: number; speed?: number }; answer: JogAnswer };
  'cell.change': { args: { robot?: string; model?: string; folder?: string }; answer: Asked };
  'cell.open': { args: { robot?: string; model?: string; folder?: string }; answer: Asked };
  'cell.reset': { args: { robot?: string; model?: string; folder?: string }; answer: Asked };
}
