/** What the pictures need, fetched once a connection: the robots' models and the scene. */
import { computed, effect, signal } from '@preact/signals';
import type { RobotModel, SceneInfo } from '../wire/types';
import { Chain } from '../view3d/chain';
import { cell, fetchJson, robot } from './cell';

export const models = signal<Record<string, RobotModel>>({});
export const scene = signal<SceneInfo | null>(null);

export const chains = computed<Record<string, Chain>>(() =>
  Object.fromEntries(Object.entries(models.value).map(([name, model]) => [name, new Chain(model)])),
);
export const chain = computed(() => chains.value[robot.value?.name ?? ''] ?? null);

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
    scene.value = await fetchJson<SceneInfo>(at);
  } catch (error) {
    console.warn('the scene cannot be had', error);
  }
}
