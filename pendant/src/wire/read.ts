/**
 * Converts messages of the server to the page's types. Missing fields get harmless values; nothing here
 * throws.
 */
import type {Alarm, CellInfo, Contacts, Facts, Holder, JogEvent, Near, PartPose, Plan, ProgramStatus, Quat, SceneInfo, SceneThing, Status, Touch, Vec3, Visual, Why} from './types';
import type { Json } from './connection';
import type { ProgramOverview } from './requests';

const list = (value: unknown): Json[] => (Array.isArray(value) ? (value as Json[]) : []);
const text = (value: unknown): string => (typeof value === 'string' ? value : '');
const factsOf = (value: unknown): Facts => (value && typeof value === 'object' ? (value as Facts) : {});
const num = (value: unknown, fallback: number): number => (typeof value === 'number' ? value : fallback);

export function readHolder(value: unknown): Holder | null {
  const holder = value as { client?: unknown; name?: unknown } | null | undefined;
  return holder && typeof holder.client === 'number' ? { client: holder.client, name: text(holder.name) } : null;
}

function readProgram(value: unknown): ProgramStatus | null {
  if (!value || typeof value !== 'object') return null;
  const program = value as Partial<ProgramOverview>;
  const { where, problem } = program;
  return {
    file: text(program.name),
    state: text(program.state) as ProgramStatus['state'],
    paused: program.paused === true,
    ended: program.ended === true,
    ready: program.state === 'ready',
    hash: text(program.hash),
    line: num(where?.line, 0),
    lineFile: text(where?.file),
    source: text(program.source),
    passes: num(program.passes, 0),
    lastPass: num(program.last_pass_s, NaN),
    problem: problem ? [problem.where, problem.what].filter(Boolean).join(': ') : '',
  };
}

function readTouch(each: Json): Touch {
  const { position } = each;
  const at = Array.isArray(position) && position.length === 3 && position.every((v) => typeof v === 'number') ? (position as Vec3) : null;
  return { a: text(each.a), b: text(each.b), depth: num(each.depth, 0), at, now: each.now === true, text: text(each.text) };
}

function readContacts(value: unknown): Contacts {
  const got = (value && typeof value === 'object' ? value : {}) as Json;
  const unchecked = Array.isArray(got.unchecked) ? got.unchecked.map(text).filter(Boolean) : [];
  const why = list(got.unchecked_why);
  return {
    checked: got.checked !== false,
    touching: got.touching === true,
    unchecked: unchecked.map((what, i) => ({what, code: text(why[i]?.code), facts: factsOf(why[i]?.facts)})),
    list: list(got.list).map(readTouch),
  };
}

function readCannot(value: unknown): Record<string, Why> {
  const out: Record<string, Why> = {};
  for (const [name, why] of Object.entries((value ?? {}) as Record<string, Json | null>))
    if (why && typeof why === 'object' && 'code' in why)
      out[name] =
          {code: text(why.code), what: text(why.what), advice: text(why.advice), facts: factsOf(why.facts)};
  return out;
}

export function readStatus(event: Json, client: number): Status {
  const holder = readHolder(event.holder);
  const cause = text(event.cause);
  return {
    state: text(event.state) as Status['state'],
    cause: cause === 'nothing' ? '' : cause,
    moving: event.standing === false,
    motionLeft: event.motion_left !== false,
    armed: event.armed !== false,
    simulated: event.simulated !== false,
    profile: text(event.profile),
    reduced: event.reduced === true || event.profile === 'reduced',
    override: num(event.override, event.state === 'no cell' ? NaN : 100),
    allowed: num(event.allowed, 100),
    holder,
    youHold: holder !== null && holder.client === client,
    clients: num(event.clients, 1),
    program: readProgram(event.program),
    failure: text(event.failure),
    inactive: Array.isArray(event.inactive) ? (event.inactive as string[]) : [],
    causeCode: text(event.cause_code),
    causeFacts: factsOf(event.cause_facts),
    contacts: readContacts(event.contacts),
    cannot: readCannot(event.can),
    cannotJog: readCannot((event.can as Json | undefined)?.jog),
    jogged: Array.isArray(event.jogged) ? (event.jogged as string[]) : [],
  };
}

/** The cell sends null for the missing limits of a joint. */
export function readCell(got: Json): CellInfo {
  const cell = got as unknown as CellInfo;
  for (const robot of cell.robots)
    for (const joint of robot.joints) {
      joint.interface ??= `${robot.name}/${joint.name}`;
      joint.lower ??= -Infinity;
      joint.upper ??= Infinity;
    }
  return cell;
}

export function readScene(got: Json): SceneInfo {
  const things: SceneThing[] = [];
  const add = (kind: string, each: Json, moving = false) => {
    const pose = (each.pose ?? { p: [0, 0, 0], q: [0, 0, 0, 1] }) as { p: Vec3; q: Quat };
    things.push({ name: text(each.name), kind, ...pose, visuals: (each.visuals ?? []) as Visual[], moving, mover: text(each.mover) });
  };
  for (const each of list(got.fixtures)) add('fixture', each);
  for (const each of list(got.parts)) {
    add('part', each, true);
    Object.assign(things[things.length - 1]!, { goalBin: text((each.goal as Json | null | undefined)?.bin), fed: text(each.feeder) !== '' });
  }
  for (const each of list(got.bins)) things.push(region('bin', each));
  return {
    floor: typeof got.floor === 'number' ? got.floor : null,
    things,
    movers: list(got.movers).map((each) => ({ name: text(each.name), axis: each.axis as Vec3, field: text(each.interface) })),
  };
}

/** A box between two corners. */
function region(kind: string, each: Json): SceneThing {
  const lower = each.lower as Vec3;
  const upper = each.upper as Vec3;
  const middle = lower.map((v, i) => (v + upper[i]!) / 2) as Vec3;
  const size = lower.map((v, i) => Math.max(1e-4, upper[i]! - v)) as Vec3;
  const identity: Quat = [0, 0, 0, 1];
  const color = (each.color ?? [0.25, 0.55, 0.35, 0.25]) as [number, number, number, number];
  const visuals: Visual[] = [{ shape: 'box', size, origin: { p: [0, 0, 0], q: identity }, color }];
  return { name: text(each.name), kind, p: middle, q: identity, visuals };
}

export function readPart(each: Json): PartPose {
  return {
    name: text(each.name),
    p: each.p as Vec3,
    q: each.q as Quat,
    here: each.in_world !== false,
    taken: each.taken === true,
    heldBy: text(each.held_by),
  };
}

/** The planned paths by robot. A robot without an entry has no plan. */
export function readPlans(event: Json): Record<string, Plan> {
  const plans = Object.entries((event.plans ?? {}) as Record<string, Json>);
  return Object.fromEntries(
    plans.map(([robot, each]) => [robot, { robot, path: Array.isArray(each.path) ? (each.path as Vec3[]) : null, clear: Array.isArray(each.clear) ? (each.clear as number[]) : [], target: (each.target ?? null) as Plan['target'] }]),
  );
}

/** What is nearest to each robot. A robot without an entry has nothing near it. */
export function readNear(event: Json): Record<string, Near> {
  const near = Object.entries((event.robots ?? {}) as Record<string, Json>);
  return Object.fromEntries(
    near.map(([robot, each]) => [
      robot,
      {
        a: text(each.a),
        b: text(each.b),
        distance: num(each.distance, NaN),
        kept: num(each.kept, NaN),
        onA: each.on_a as Vec3,
        onB: each.on_b as Vec3,
        pace: num(each.pace, 1),
      },
    ]),
  );
}

export function readAlarm(event: Json): Alarm {
  const where = event.where as { file?: string; line?: number } | string | null | undefined;
  const place = typeof where === 'object' && where ? [where.file, where.line || ''].filter(Boolean).join(':') : text(where);
  return {
    number: num(event.number, 0),
    time: num(event.time, 0),
    code: text(event.code),
    what: text(event.what),
    where: place,
    advice: text(event.advice),
    facts: factsOf(event.facts),
    severity: event.severity === 'warning' ? 'warning' : 'error',
  };
}

export function readJog(event: Json): JogEvent {
  return {
    robot: text(event.robot),
    jog: num(event.jog, -1),
    over: event.over === true,
    why: text(event.why),
    text: text(event.text),
    which: text(event.which),
  };
}
