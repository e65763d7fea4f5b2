/** The cell as signals: connection, status, control, tags, parts, alarms, log. Pages read these and call `actions`. */
import {computed, effect, signal} from '@preact/signals';

import {type Key, t} from '../i18n';
import {problemWords} from '../i18n/told';

import { Connection, type Json, type LinkState, RequestError } from '../wire/connection';
import { type Field, Layout, parseFrame } from '../wire/frames';
import type {
  Alarm,
  CellInfo,
  Holder,
  JogEvent,
  LogLine,
  PartPose,
  Plan,
  RobotInfo,
  Status,
  TagValue,
} from '../wire/types';
import type { Requests } from '../wire/requests';
import { readAlarm, readCell, readHolder, readJog, readPart, readPlans, readStatus } from '../wire/read';
import { forgetFrames, takeFrame, takeLayout } from './live';
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
/** Who asks for the control that is ours, and until when (performance.now()). */
export const asked = signal<{ client: number; name: string; until: number } | null>(null);
/** This page runs on the machine of the cell, and may take control without asking. */
export const mayForce = signal(false);
/** We have asked for control and wait for an answer until then. */
export const waiting = signal<{ name: string; until: number } | null>(null);
export const tags = signal<Record<string, TagValue>>({});
export const parts = signal<Record<string, PartPose>>({});
export const plans = signal<Record<string, Plan>>({});
export const alarms = signal<Alarm[]>([]);
export const log = signal<LogLine[]>([]);
/** The whole program state as it comes (tasks, variables); the short one is `status.program`. */
export const program = signal<Json | null>(null);
export const jogEvents = signal<JogEvent | null>(null);
/** A pause or a step was asked for, and the statement under way goes on until its end. */
export const pausing = signal(false);
/** The robot that Move and the 3D view look at. */
export const robotName = signal('');

export const robot = computed<RobotInfo | null>(() => {
  const robots = cell.value?.robots ?? [];
  return robots.find((r) => r.name === robotName.value) ?? robots[0] ?? null;
});
export const connected = computed(() => link.value === 'open' && status.value !== null);
/** May this page move the robot now? */
export const mayMove = computed(() => connected.value && youHold.value);
/** What a person can do now: every key is drawn from it. */
export const ways =
    computed(() => waysOf({status: status.value, mayMove: mayMove.value, pausing: pausing.value}));
/** Why the robot that Move looks at cannot be jogged; '' where it can. */
export const jogBlocked = computed(() => ways.value.jog(robot.value?.name ?? ''));
/** A program is under way and neither paused nor waiting to be started. */
export const programRuns = computed(() => {
  const it = status.value?.program;
  return !!it && !it.ended && !it.ready && !it.paused;
});
export const unseenAlarms = computed(() => alarms.value.filter((a) => !a.seen).length);
/** Tags whose values somebody forces. */
export const forced = computed(() => Object.keys(tags.value).filter((name) => tags.value[name]!.forced).sort());

const kLogLines = 2000;
const kAlarms = 200;
const kFrameRate = 30;

let connection: Connection | null = null;

export type RequestName = keyof Requests;
export type Args<Name extends RequestName> = Requests[Name]['args'];
export type Answer<Name extends RequestName> = Requests[Name]['answer'];
/** Arguments may be left out where none is needed. */
type Rest<Name extends RequestName> = object extends Args<Name> ? [args?: Args<Name>, timeout?: number] : [args: Args<Name>, timeout?: number];

/** Arguments and answer have the types that the cell has for them (wire/requests.ts). */
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

/** Asks, and says in a toast what went wrong. True where it was done. */
export async function attempt<Name extends RequestName>(name: Name, ...rest: Rest<Name>): Promise<boolean> {
  try {
    await request(name, ...rest);
    return true;
  } catch (error) {
    complain(error);
    return false;
  }
}

/** A person stopped it or canceled it: that is an answer to what they pressed, and no error. */
const kByPerson = new Set(['discarded', 'stopped', 'overtaken']);
export const isByPerson = (code: string): boolean => kByPerson.has(code);

export function complain(error: unknown): void {
  if (error instanceof RequestError) {
    if (isByPerson(error.code)) return toast({ kind: 'info', text: t(`told.${error.code}` as Key) });
    const control = error.code === 'no-control';
    const told = problemWords(error.problem);
    toast({
      kind: control ? 'warning' : 'error',
      text: control ? t('control.needed') : told.text,
      detail: control ? '' : [told.detail, placeOf(error.problem.where), told.advice].filter(Boolean).join(' · '),
    });
  } else toast({ kind: 'error', text: String(error) });
}

/** The server tells a place as an object, or as words. */
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

/** This page was connected before. */
let greeted = false;
/** The greeting of this connection is over: control is where it stays until somebody changes that. */
const settled = signal(false);
/** It had control when the connection was last there. */
let heldBefore = false;
effect(() => {
  if (settled.value && status.value !== null) heldBefore = youHold.value;
});

async function greet(): Promise<void> {
  const again = greeted, hadControl = heldBefore;  // as they were, since answers and events change both
  try {
    const hello = await request('session.hello', { name: settings.clientName.value });
    client.value = Number(hello.client ?? -1);
    version.value = String(hello.version ?? '');
    holder.value = readHolder(hello.holder);
    mayForce.value = hello.local === true;
    youHold.value = hello.you_hold === true;
    await request('session.watch', { rate: kFrameRate });
    greeted = true;
    // A cell that nobody controls is taken by who opens the page; one that has a holder is only watched. After a
    // lost connection the page that had control takes it again, and pages that only watched go on watching.
    if (!holder.value && settings.takeWhenFree.value && (!again || hadControl)) await takeControl(false);
    settled.value = true;
  } catch (error) {
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

export async function answerAsked(give: boolean): Promise<void> {
  asked.value = null;
  await attempt('session.answer', { give });
}

/** Some alarms were looked at: they are not announced any more. */
export function markSeen(which: (alarm: Alarm) => boolean): void {
  alarms.value = alarms.peek().map((each) => (which(each) ? { ...each, seen: true } : each));
}

/** The first state is asked for; changes come by themselves. A cell without a program refuses. */
async function loadProgram(): Promise<void> {
  const now = await request('program').catch(() => null);
  if (now && !program.peek()) program.value = now as unknown as Json;
}

/** The newest alarm when this page came; -1 while that is not known. */
let lastOld = -1;
/**
 * The alarms of the connection before. The cell sends all of its alarms again after a connection; a process that
 * was started anew does not have these.
 */
let alarmsBefore: Alarm[] = [];
const isSame = (a: Alarm, b: Alarm) => a.number === b.number && a.time === b.time && a.what === b.what;

type Event = Json & { event: string };
const events: Record<string, (event: Event) => void> = {
  // A cell that begins has a layout of its own: all that is known of the one before is asked for anew.
  layout: (e) => {
    takeLayout(new Layout(Number(e.id), e.fields as Field[]));
    plans.value = {};
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
    const lines = e.lines as LogLine[];
    const last = log.value[log.value.length - 1]?.number ?? -1;
    // After a reconnect the history comes again; a new cell counts from the beginning.
    const again = lines.length > 0 && lines[0]!.number <= last;
    const known = again && lines[lines.length - 1]!.number < last ? [] : log.value;
    log.value = [...known, ...lines.filter((line) => known.length === 0 || line.number > last)].slice(-kLogLines);
  },
  alarm: (e) => {
    const alarm = readAlarm(e);
    if (alarms.value.some((each) => isSame(each, alarm))) return;
    // Those from before this page came are listed, and announced where the cell stands for one of them.
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
    if (youHold.value && what === 'given')
      toast({kind: 'ok', text: t('control.yours')});
    else if (what === 'refused')
      toast({kind: 'warning', text: t('control.refused')});
    else if (!youHold.value && (what === 'taken' || what === 'lost' || what === 'given'))
      toast({ kind: 'warning', text: t('control.taken', { name }) });
  },
};

/** More events for pages; those who asked before are told first. */
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
  // What is not current is not shown.
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
