/**
 * The one manual motion of this page, as signals. It ends on every event after which the key may no longer be
 * held.
 */
import { effect, signal } from '@preact/signals';
import { Follower } from '../wire/follower';
import { Jogger, type JogWire } from '../wire/jogger';
import type { Json } from '../wire/connection';
import type { JogBegun } from '../wire/requests';
import { t } from '../i18n';
import { type Args, complain, connected, jogEvents, mayMove, request, robot, status, tell } from './cell';
import { toast } from './toasts';
import { kept } from './settings';

export type JogMode = 'joint' | 'base' | 'world' | 'tool' | 'user' | 'drive';

/** The held key: `joint/2/+1`, `goto` …; empty if none. */
export const heldKey = signal('');
/** The held key that waits until this page's steps are done; empty: none. */
let waitsForSteps = '';
export const heldBack = signal<{what: string; which: string}|null>(null);
export const jogMode = kept<JogMode>('jogMode', 'joint');
export const userFrame = kept<string>('userFrame', '');
/** Percent of the maximum jog speed. */
export const jogSpeed = kept<number>('jogSpeed', 40);
/** 0: moves while the key is held; else the step in mm and degrees. */
export const jogStep = kept<number>('jogStep', 0);

/** The angle of a step of this many mm; at most 5°. */
export const stepDegrees = (step: number) => Math.min(step, 5);

/** The callers in this file and on the Move page choose the arguments. */
const wire: JogWire = {
  request: (name, args) => request<'jog.begin' | 'jog.goto'>(name, args as Args<'jog.begin'>) as Promise<JogBegun>,
  tell: (name, args) => tell<'jog.beat' | 'jog.end'>(name, args),
};
const jogger = new Jogger(wire, (held, error) => {
  if (!held) heldKey.value = '';
  if (error) complain(error);
});

const follower = new Follower((name, args, timeout) => request(name, args, timeout), (error) => {
  heldKey.value = '';
  if (error) complain(error);
});

export function frameName(): string {
  return jogMode.peek() === 'user' ? `user:${userFrame.peek()}` : jogMode.peek();
}

export function jogArgs(axis: number | number[], direction: number): Json {
  const joint = jogMode.peek() === 'joint';
  const drives = jogMode.peek() === 'drive';
  const frame = joint || drives ? {} : { frame: frameName() };
  return {
    robot: robot.peek()?.name ?? '',
    mode: joint ? 'joint' : drives ? 'drive' : 'tcp',
    ...frame,
    axis,
    ...(Array.isArray(axis) ? {} : { direction }),
    speed: jogSpeed.peek() / 100,
  };
}

/** A key was pressed: makes a step, or moves until the key is released. */
export function pressJog(axis: number, direction: 1 | -1): void {
  if (!mayMove.peek()) return;
  const key = `${jogMode.peek()}/${axis}/${direction}`;
  if (jogStep.peek() > 0 && jogMode.peek() !== 'drive') return step(axis, direction, key);
  heldBack.value = null;
  heldKey.value = key;
  const begin = () => {
    void jogger.begin({ request: 'jog.begin', args: jogArgs(axis, direction) });
    heldKey.value = key;
  };
  if (stepsToGo.peek() === 0) return begin();
  waitsForSteps = key;
  void last.then(() => {
    if (waitsForSteps !== key || !mayMove.peek()) return;
    waitsForSteps = '';
    begin();
  });
}

/** A stick was moved. `axis`: fractions of the speed along and about x, y, z. */
export function pushJog(key: string, wish: number[]): void {
  const axis = jogMode.peek() === 'drive' ? [wish[0]!, wish[5]!] : wish;
  if (heldKey.peek() === key) return jogger.steer({ axis });
  if (!mayMove.peek() || heldKey.peek() !== '') return;
  heldBack.value = null;
  void jogger.begin({ request: 'jog.begin', args: jogArgs(axis, 1) });
  heldKey.value = key;
}

/** Goes to the target of `jog.goto`, on the way that the cell plans, while the key is held. */
export function pressGoTo(args: Json): void {
  if (!mayMove.peek()) return;
  release();
  heldBack.value = null;
  void jogger.begin({ request: 'jog.goto', args: { speed: jogSpeed.peek() / 100, ...args } });
  heldKey.value = 'goto';
}

function followArgs(goal: Json): Json {
  return { robot: robot.peek()?.name ?? '', speed: jogSpeed.peek() / 100, ...goal };
}

/** The handle in the picture is held. The robot follows its target. */
export function holdHandle(): void {
  if (!mayMove.peek()) return;
  release();
  follower.begin(null);
  heldKey.value = 'handle';
}
export function dragHandle(position: number[], orientation: number[]): void {
  if (heldKey.peek() === 'handle') follower.set(followArgs({ pose: { position, orientation }, frame: 'world' }));
}

export function release(): void {
  if (waitsForSteps !== '' && heldKey.peek() === waitsForSteps) heldKey.value = '';
  waitsForSteps = '';
  jogger.end();
  follower.end();
}

/** Number of steps that were requested and are not done yet. */
export const stepsToGo = signal(0);
const kMostSteps = 20;
/** Increases when waiting steps are dropped. */
let round = 0;
let last: Promise<void> = Promise.resolve();

/**
 * Every press counts: a step waits for those before it. A refused step, or the loss of control, drops all
 * waiting steps.
 */
function step(axis: number, direction: number, key: string): void {
  if (stepsToGo.peek() >= kMostSteps) return toast({ kind: 'warning', text: t('move.queueFull', { most: kMostSteps }) });
  const joint = jogMode.peek() === 'joint';
  const turns = joint ? robot.peek()?.joints[axis]?.unit !== 'm' : axis >= 3;
  const amount = direction * (turns ? stepDegrees(jogStep.peek()) * (Math.PI / 180) : jogStep.peek() * 0.001);
  // The arguments at the time of the press; later changes of the settings do not apply.
  const { direction: _, ...args } = jogArgs(axis, direction) as Json & { direction: number };
  ++stepsToGo.value;
  const mine = round;
  last = last
    .then(() => (mine === round ? oneStep({ ...args, amount }, key) : undefined))
    .finally(() => {
      if (mine === round) --stepsToGo.value;
    });
}

export function dropSteps(): void {
  ++round;
  stepsToGo.value = 0;
}

async function oneStep(args: Json, key: string): Promise<void> {
  heldKey.value = key;
  try {
    await request('jog.step', args as Args<'jog.step'>, 30_000);
  } catch (error) {
    dropSteps();
    complain(error);
  } finally {
    if (heldKey.peek() === key) heldKey.value = '';
  }
}

effect(() => {
  const event = jogEvents.value;
  if (!event) return;
  if (event.over) {
    if (jogger.ended(event.jog) && event.why === 'lost') toast({kind: 'warning', text: t('move.lost')});
    return;
  }
  heldBack.value = event.why ? {what: event.why, which: event.which} : null;
});
effect(() => {
  if (!connected.value || !mayMove.value) {
    release();
    dropSteps();
  }
});
// A stop by any client also drops the waiting steps.
let stateBefore = '';
effect(() => {
  const state = status.value?.state ?? '';
  if (state !== stateBefore) dropSteps();
  stateBefore = state;
});
addEventListener('blur', release);
addEventListener('blur', dropSteps);
addEventListener('pagehide', release);
document.addEventListener('visibilitychange', () => {
  if (document.visibilityState !== 'visible') release();
});
