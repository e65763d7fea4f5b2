/** What the pictures need, fetched once a connection: the robots' models and the scene. */
import { computed, effect, signal } from '@preact/signals';
import type { Json } from '../wire/connection';
import { readCell, readScene } from '../wire/read';
import type { FrameInfo, Pose, RobotInfo, RobotModel, SceneInfo } from '../wire/types';
import { Chain, frameInWorld } from '../view3d/chain';
import { cell, fetchJson, onEvent, robot } from './cell';
import { valueNow } from './live';

export const models = signal<Record<string, RobotModel>>({});
export const scene = signal<SceneInfo | null>(null);

export const chains = computed<Record<string, Chain>>(() =>
  Object.fromEntries(Object.entries(models.value).map(([name, model]) => [name, new Chain(model)])),
);
export const chain = computed(() => chains.value[robot.value?.name ?? ''] ?? null);

/** Frames of the cell's data as they are told, each in another one, a base or the world. */
const told = signal<FrameInfo[]>([]);
/** The same in the world: what a person may jog in. Those whose frame is not known are left out. */
export const frames = computed(() =>
  told.value.flatMap(({ name }) => {
    const pose = frameInWorld(name, told.value, cell.value?.robots ?? []);
    return pose ? [{ name, ...pose }] : [];
  }),
);
effect(() => {
  told.value = cell.value?.frames ?? [];
});
onEvent('points', () => {
  fetchJson<Json>('/api/cell').then(
    (got) => (told.value = readCell(got).frames ?? []),
    (error: unknown) => console.warn('the frames cannot be had', error),
  );
});

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

/** Again after the scene was reset or another one was opened. */
export async function loadScene(): Promise<void> {
  const at = cell.peek()?.scene;
  if (!at) return;
  try {
    scene.value = readScene(await fetchJson<Json>(at));
  } catch (error) {
    console.warn('the scene cannot be had', error);
  }
}

const fields = computed(() => {
  const out = new Map<string, string>();
  for (const each of cell.value?.robots ?? [])
    for (const joint of each.joints) out.set(`${each.name}/${joint.name}`, `${joint.interface}/position`);
  return out;
});

/** Where the joints of a robot's model are now, by name; NaN for those that have no value. */
export function jointValues(robot: string): (joint: string) => number {
  const known = fields.value;
  return (joint) => valueNow(known.get(`${robot}/${joint}`) ?? '');
}

export function jointNow(robot: RobotInfo, index: number): number {
  return valueNow(`${robot.joints[index]?.interface ?? ''}/position`);
}

/** Where a base that drives is, as the frames tell it; null for one that is fixed. Everything else told of its robot is so as if it stood at `RobotInfo.base`. */
export function baseNow(robot: string): Pose | null {
  const of = (what: string) => valueNow(`${robot}/base/${what}`);
  const p: Pose['p'] = [of('position.x'), of('position.y'), of('position.z')];
  const q: Pose['q'] = [of('orientation.x'), of('orientation.y'), of('orientation.z'), of('orientation.w')];
  return [...p, ...q].every(Number.isFinite) ? { p, q } : null;
}
