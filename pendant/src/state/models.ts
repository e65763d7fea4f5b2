/** The data of the pictures, loaded once per connection: the robots' models and the scene. */
import { computed, effect, signal } from '@preact/signals';
import type { Json } from '../wire/connection';
import { readScene } from '../wire/read';
import type { Pose, RobotInfo, RobotModel, SceneInfo } from '../wire/types';
import { Chain } from '../view3d/chain';
import { cell, fetchJson, onEvent, request, robot } from './cell';
import { valueNow } from './live';

export const models = signal<Record<string, RobotModel>>({});
export const scene = signal<SceneInfo | null>(null);

export const chains = computed<Record<string, Chain>>(() =>
  Object.fromEntries(Object.entries(models.value).map(([name, model]) => [name, new Chain(model)])),
);
export const chain = computed(() => chains.value[robot.value?.name ?? ''] ?? null);

/** Points of the cell's data, in the world. The user may jog in each of them as a frame. */
export const frames = signal<({ name: string } & Pose)[]>([]);
function loadFrames(): void {
  request('points').then(
    ({ values }) => (frames.value = values.flatMap(({ name, kind, world }) => (kind === 'pose' && world ? [{ name, ...world }] : []))),
    (error: unknown) => console.warn('the frames cannot be had', error),
  );
}
effect(() => {
  if (cell.value) loadFrames();
});
onEvent('points', loadFrames);

effect(() => {
  const now = cell.value;
  if (!now) return;
  for (const each of now.robots)
    fetchJson<RobotModel>(each.model).then(
      (model) => (models.value = { ...models.peek(), [each.name]: model }),
      (error: unknown) => console.warn(`the model of ${each.name} cannot be had`, error),
    );
  void loadScene();
});

/** Loads the scene again after it was reset or another one was opened. */
export async function loadScene(): Promise<void> {
  const at = cell.peek()?.scene;
  if (!at) return;
  try {
    scene.value = readScene(await fetchJson<Json>(at));
  } catch (error) {
    console.warn('the scene cannot be had', error);
  }
}

/**
 * The indices of the robot's joints in the order from base to TCP. Joints that do not lead to the TCP come
 * last.
 */
export function armOrder(info: RobotInfo): number[] {
  const way = chains.value[info.name]?.path().map((joint) => joint.name) ?? [];
  const rank = (i: number) => (way.includes(info.joints[i]!.name) ? way.indexOf(info.joints[i]!.name) : way.length + i);
  return info.joints.map((_, i) => i).sort((a, b) => rank(a) - rank(b));
}

const fields = computed(() => {
  const out = new Map<string, string>();
  for (const each of cell.value?.robots ?? [])
    for (const joint of each.joints) out.set(`${each.name}/${joint.name}`, `${joint.interface}/position`);
  return out;
});

/** The present joint values of a robot's model, by name; NaN if a joint has no value. */
export function jointValues(robot: string): (joint: string) => number {
  const known = fields.value;
  return (joint) => valueNow(known.get(`${robot}/${joint}`) ?? '');
}

export function jointNow(robot: RobotInfo, index: number): number {
  return valueNow(`${robot.joints[index]?.interface ?? ''}/position`);
}

/**
 * The present pose of a mobile base from the frames; null for a fixed base. All other values of the robot are
 * reported as if its base stood at `RobotInfo.base`.
 */
export function baseNow(robot: string): Pose | null {
  const of = (what: string) => valueNow(`${robot}/base/${what}`);
  const p: Pose['p'] = [of('position.x'), of('position.y'), of('position.z')];
  const q: Pose['q'] = [of('orientation.x'), of('orientation.y'), of('orientation.z'), of('orientation.w')];
  return [...p, ...q].every(Number.isFinite) ? { p, q } : null;
}
