/**
 * The cell as signals: connection, status, control, tags, parts, alarms, log. Pages read these signals and
 * call `actions`.
 */
import {computed, effect, signal} from '@preact/signals';

import {type Key, t} from '../i18n';
import {forwardRobots, problemWords} from '../i18n/told';

import { Connection, type Json, type LinkState, RequestError } from '../wire/connection';
import { type Field, Layout, parseFrame } from '../wire/frames';
import type {
  Alarm,
  CellInfo,
  Holder,
  JogEvent,
  LogLine,
  Near,
  PartPose,
  Plan,
  RobotInfo,
  Status,
  TagValue,
} from '../wire/types';
import type { Requests, SessionHelloAnswer } from '../wire/requests';
import { readAlarm, readCell, readHolder, readJog, readPart, readNear, readPlans, readStatus } from '../wire/read';
import { forgetFrames, takeFrame, takeLayout } from './live';
import { withLines } from './log';
import { settings } from './settings';
import { toast } from './toasts';
import {waysOf} from './ways';

export const link = signal<LinkState>('connecting');
export const client = signal(-1);
export const version = signal('');
export const cell = signal<CellInfo | null>(null);
export const status = signal<Status | null>(null);
export const holder = signal<Holder | null>(null);
export const youHold = signal(false);
/** The client that asks for this page's control, and until when (performance.now()). */
export const asked = signal<{ client: number; name: string; until: number } | null>(null);
/** True if this page runs on the computer of the cell, and may take control without asking. */
export const mayForce = signal(false);
/** This page has asked for control and waits for an answer until then. */
export const waiting = signal<{ name: string; until: number } | null>(null);
export const tags = signal<Record<string, TagValue>>({});
export const parts = signal<Record<string, PartPose>>({});
export const plans = signal<Record<string, Plan>>({});
/** What is nearest to each robot that moves. */
export const nears = signal<Record<string, Near>>({});
export const alarms = signal<Alarm[]>([]);
export const log = signal<LogLine[]>([]);
/** The complete state of the program (tasks, variables). `status.program` is the summary. */
export const program = signal<Json | null>(null);
export const jogEvents = signal<JogEvent | null>(null);
/** True after a request to pause or step, until the present statement has ended. */
export const pausing = signal(false);
/** The robot that the Move page and the 3D view show. */
export const robotName = signal('');

export const robot = computed<RobotInfo | null>(() => {
  const robots = cell.value?.robots ?? [];
  return robots.find((r) => r.name === robotName.value) ?? robots[0] ?? null;
});
/** What this page's link or user allows. */
export const role = signal<SessionHelloAnswer['role']>('administer');
const kRoles = ['watch', 'operate', 'program', 'administer'] as const;
export const mayAs = (needed: SessionHelloAnswer['role']): boolean => kRoles.indexOf(role.value) >= kRoles.indexOf(needed);
/** The role watch never gets control. */
export const mayTake = computed(() => mayAs('operate'));
export const connected = computed(() => link.value === 'open' && status.value !== null);
/** True if this page may move the robot now. */
export const mayMove = computed(() => connected.value && youHold.value);
/** True if this page may change programs and points now. */
export const mayProgram = computed(() => mayMove.value && mayAs('program'));
/** True if this page may change the cell itself now. */
export const mayAdminister = computed(() => mayMove.value && mayAs('administer'));
/** The possible actions. Every key is drawn from them. */
export const ways =
    computed(() => waysOf({status: status.value, mayMove: mayMove.value, pausing: pausing.value}));
/** Why the robot of the Move page cannot be jogged; '' if it can. */
export const jogBlocked = computed(() => ways.value.jog(robot.value?.name ?? ''));
/** True if a program is running: neither paused nor waiting to be started. */
export const programRuns = computed(() => {
  const it = status.value?.program;
  return !!it && !it.ended && !it.ready && !it.paused;
});
export const unseenAlarms = computed(() => alarms.value.filter((a) => !a.seen).length);
/** The names of forced tags. */
export const forced = computed(() => Object.keys(tags.value).filter((name) => tags.value[name]!.forced).sort());

const kAlarms = 200;
const kFrameRate = 30;

let connection: Connection | null = null;

export type RequestName = keyof Requests;
export type Args<Name extends RequestName> = Requests[Name]['args'];
export type Answer<Name extends RequestName> = Requests[Name]['answer'];
/** Arguments may be omitted if none is required. */
type Rest<Name extends RequestName> = object extends Args<Name> ? [args?: Args<Name>, timeout?: number] : [args: Args<Name>, timeout?: number];

/** Sends a request. The types of arguments and answer are those of the cell (wire/requests.ts). */
export function request<Name extends RequestName>(name: Name, ...[args, timeout]: Rest<Name>): Promise<Answer<Name>> {
  if (!connection) return Promise.reject(new RequestError(name, { code: 'not-connected', what: t('link.lost') }));
  return connection.request<Answer<Name>>(name, (args ?? {}) as Json, timeout);
}
export function tell<Name extends RequestName>(name: Name, ...[args]: Rest<Name>): boolean {
  return connection?.tell(name, (args ?? {}) as Json) ?? false;
}
export function stream<Name extends RequestName>(name: Name, args: Args<Name>, each: (result: Answer<Name>) => void) {
  if (!connection) throw new RequestError(name, { code: 'not-connected', what: t('link.lost') });
  return connection.stream<Answer<Name>>(name, args as Json, each);
}

/** Sends a request and shows an error as a toast. Returns true on success. */
export async function attempt<Name extends RequestName>(name: Name, ...rest: Rest<Name>): Promise<boolean> {
  try {
    await request(name, ...rest);
    return true;
  } catch (error) {
    complain(error);
    return false;
  }
}

/** Codes for motions that a person stopped or cancelled. That is information, not an error. */
const kByPerson = new Set(['discarded', 'stopped', 'overtaken']);
export const isByPerson = (code: string): boolean => kByPerson.has(code);

export function complain(error: unknown): void {
  if (error instanceof RequestError) {
    if (isByPerson(error.code)) return toast({ kind: 'info', text: t(`told.${error.code}` as Key) });
    const control = error.code === 'no-control';
    const told = problemWords(error.problem);
    toast({
      kind: control ? 'warning' : 'error',
      text: control ? t(mayTake.value ? 'control.needed' : 'control.roleWatch') : told.text,
      detail: control ? '' : [told.detail, placeOf(error.problem.where), told.advice].filter(Boolean).join(' · '),
    });
  } else toast({ kind: 'error', text: String(error) });
}

/** The server sends a location as an object or as text. */
function placeOf(where: unknown): string {
  if (typeof where === 'string') return where;
  const { file, line } = (where ?? {}) as { file?: string; line?: number };
  return file ? [file, line || ''].filter(Boolean).join(':') : '';
}

export async function fetchJson<T>(path: string): Promise<T> {
  const answer = await fetch(path, { credentials: 'same-origin' });
  if (!answer.ok) {
    const text = await answer.text().catch(() => '');
    throw new RequestError(path, { code: `http-${answer.status}`, what: text.slice(0, 300) || answer.statusText });
  }
  return (await answer.json()) as T;
}

export async function loadCell(): Promise<void> {
  cell.value = readCell(await fetchJson<Json>('/api/cell'));
  document.title = `${cell.value.name} · Polyarm`;
}

/** True if this page was connected before. */
let greeted = false;
/**
 * True once the greeting of this connection is done. Control then stays where it is until somebody changes
 * it.
 */
const settled = signal(false);
/** True if this page had control when the connection was last open. */
let heldBefore = false;
effect(() => {
  if (settled.value && status.value !== null) heldBefore = youHold.value || waitsForControl();
});
/**
 * After a reconnection: until then (performance.now()) this page takes the control that it had, once the cell has noticed
 * that the old connection is gone.
 */
let takesUntil = 0;
/** The number that this page had when it had control; the cell may count it as connected for some time. */
let former = -1;
const kTakesWithinMs = 30_000;
const waitsForControl = () => performance.now() < takesUntil;

async function greet(before = waitsForControl() ? former : client.peek()): Promise<void> {
  const again = greeted, hadControl = heldBefore;  // copies, because answers and events change both
  try {
    const hello = await request('session.hello', { name: settings.clientName.value });
    client.value = Number(hello.client ?? -1);
    version.value = String(hello.version ?? '');
    holder.value = readHolder(hello.holder);
    role.value = hello.role;
    mayForce.value = hello.local === true;
    youHold.value = hello.you_hold === true;
    await request('session.watch', { rate: kFrameRate });
    greeted = true;
    // A page takes control when it opens if no client has it; otherwise it only watches. After a lost
    // connection the page that had control takes it again, and the others only watch.
    const takes = mayTake.value && settings.takeWhenFree.value && (!again || hadControl);
    if (takes && !holder.value) await takeControl(false);
    takesUntil = takes && again && !youHold.value && holder.value?.client === before ? performance.now() + kTakesWithinMs : 0;
    former = before;
    settled.value = true;
  } catch (error) {
    if (isLate(error)) return greet(before);
    if (link.value === 'open') complain(error);
  }
}

export async function takeControl(force: boolean): Promise<void> {
  try {
    const answer = await request('session.take', force ? { force: true } : {});
    if (answer.you_hold === true) {
      youHold.value = true;
      waiting.value = null;
    } else {
      const within = Number(answer.seconds ?? 10);
      waiting.value = { name: holder.value?.name ?? '', until: performance.now() + 1000 * within };
    }
  } catch (error) {
    complain(error);
  }
}

export async function releaseControl(): Promise<void> {
  if (await attempt('session.release')) youHold.value = false;
}

export async function answerQuestion(give: boolean): Promise<void> {
  asked.value = null;
  await attempt('session.answer', { give });
}

/** Marks alarms as seen. They are not announced any more. */
export function markSeen(which: (alarm: Alarm) => boolean): void {
  alarms.value = alarms.peek().map((each) => (which(each) ? { ...each, seen: true } : each));
}

/** True if a request got no answer in time, although there is a connection. A busy machine may be late. */
const isLate = (error: unknown): boolean => error instanceof RequestError && error.code === 'no-answer' && link.peek() === 'open';

/** Requests the first state; later changes come as events. A cell without a program refuses. */
async function loadProgram(): Promise<void> {
  try {
    const now = await request('program');
    if (!program.peek()) program.value = now as unknown as Json;
  } catch (error) {
    if (isLate(error) && !program.peek()) return loadProgram();
  }
}

/** As text, so that a status with the same robots changes nothing. */
const forwardNow = computed(() => {
  const robots = Object.entries(status.value?.cannotJog ?? {});
  const names = robots.filter(([, why]) => why.code === 'forward-mode').map(([name]) => name);
  return JSON.stringify({names, all: names.length > 0 && names.length === (cell.value?.robots.length ?? 0)});
});
effect(() => void (forwardRobots.value = JSON.parse(forwardNow.value)));

/** The number of the newest alarm before this page connected; -1 while unknown. */
let lastOld = -1;
/**
 * The alarms before the last reconnection. The cell sends all its alarms again after a connection; a
 * restarted process does not have these.
 */
let alarmsBefore: Alarm[] = [];
const isSame = (a: Alarm, b: Alarm) => a.number === b.number && a.time === b.time && a.what === b.what;

type Event = Json & { event: string };
const events: Record<string, (event: Event) => void> = {
  // A new cell sends its own layout. The page then requests everything again.
  layout: (e) => {
    takeLayout(new Layout(Number(e.id), e.fields as Field[]));
    plans.value = {};
    nears.value = {};
    program.value = null;
    void loadProgram();
    loadCell().catch(complain);
  },
  status: (e) => {
    const next = readStatus(e, client.peek());
    status.value = next;
    holder.value = next.holder;
    youHold.value = next.youHold;
    if (youHold.value)
      waiting.value = null;
    else
      asked.value = null;
    if (waitsForControl() && next.holder?.client !== former) {
      takesUntil = 0;
      if (!next.holder) void takeControl(false);
    }
    if (lastOld < 0) lastOld = Number(e.alarms ?? 0);
    if (!next.program || next.program.ended || next.program.paused) pausing.value = false;
  },
  tags: (e) => {
    const values = e.values as Record<string, TagValue>;
    tags.value = e.full === true ? values : { ...tags.value, ...values };
  },
  parts: (e) => {
    const next: Record<string, PartPose> = e.full === true ? {} : { ...parts.value };
    for (const part of (e.parts as Json[]).map(readPart)) next[part.name] = part;
    parts.value = next;
  },
  log: (e) => {
    log.value = withLines(log.value, e.lines as LogLine[]);
  },
  alarm: (e) => {
    const alarm = readAlarm(e);
    if (alarms.value.some((each) => isSame(each, alarm))) return;
    // Alarms from before this page connected are listed. They are announced only if the cell does not run.
    const old = lastOld < 0 || alarm.number <= lastOld;
    const known = alarmsBefore.find((each) => isSame(each, alarm));
    alarm.seen = known?.seen || isByPerson(alarm.code) || (old && status.peek()?.state === 'running');
    alarms.value = [...alarms.value, alarm].slice(-kAlarms);
  },
  program: (e) => {
    program.value = e;
  },
  plan: (e) => {
    plans.value = readPlans(e);
  },
  near: (e) => {
    nears.value = readNear(e);
  },
  jog: (e) => {
    jogEvents.value = readJog(e);
  },
  asked: (e) => {
    asked.value = {
      client: Number(e.client),
      name: String(e.name ?? ''),
      until: performance.now() + 1000 * Number(e.seconds ?? 10),
    };
  },
  control: (e) => {
    const what = String(e.what ?? '');
    const name = String(e.name || t('control.someone'));
    youHold.value = e.you_hold === true;
    asked.value = null;
    waiting.value = null;
    if (what === 'taken' || what === 'given') takesUntil = 0;
    if (youHold.value && what === 'given')
      toast({kind: 'ok', text: t('control.yours')});
    else if (what === 'refused')
      toast({kind: 'warning', text: t('control.refused')});
    else if (!youHold.value && (what === 'taken' || what === 'lost' || what === 'given'))
      toast({ kind: 'warning', text: t('control.taken', { name }) });
  },
};

/** Adds a handler for an event of a page. Handlers are called in the order in which they were added. */
export function onEvent(name: string, take: (event: Json) => void): void {
  const before = events[name];
  events[name] = (event) => {
    before?.(event);
    take(event);
  };
}

let wasOpen = false;
function changeLink(state: LinkState): void {
  link.value = state;
  settled.value = false;
  if (state === 'open') {
    lastOld = -1;
    if (alarms.peek().length > 0) alarmsBefore = alarms.peek();
    alarms.value = [];
    if (wasOpen) toast({ kind: 'ok', text: t('link.back') });
    wasOpen = true;
    forgetFrames();
    void greet();
    return;
  }
  if (state === 'connecting') return;
  status.value = null;
  youHold.value = false;
  holder.value = null;
  asked.value = null;
  waiting.value = null;
  plans.value = {};
  nears.value = {};
  // Old values are not shown.
  tags.value = {};
  program.value = null;
  pausing.value = false;
  forgetFrames();
}

export function connect(): void {
  const address = `${location.protocol === 'https:' ? 'wss' : 'ws'}://${location.host}/ws`;
  connection = new Connection({
    open: () => new WebSocket(address),
    onEvent: (event) => events[event.event]?.(event),
    onFrame: (buffer) => {
      const frame = parseFrame(buffer);
      if (frame) takeFrame(frame);
    },
    onState: changeLink,
    mayBeSilent: () => status.peek()?.state === 'no cell',
  });
  connection.start();
  addEventListener('online', () => connection?.hurry());
  document.addEventListener('visibilitychange', () => {
    if (document.visibilityState === 'visible') connection?.hurry();
  });
}
