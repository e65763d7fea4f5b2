/**
 * Tags with all their properties: constant properties are requested, values come as events. Also the forces
 * and simulations of this page.
 */
import { effect, signal } from '@preact/signals';
import type { LinkState, TagState } from '../wire/requests';
import { complain, connected, request, stream, tags } from './cell';

export const tagInfos = signal<TagState[]>([]);
export const links = signal<LinkState[]>([]);
export const tagsKnown = signal(false);

const kEvery = 2000;

export async function loadTags(): Promise<void> {
  try {
    const answer = await request('tags.list');
    let all = answer.tags;
    // Data variables are missing in the list of tags, but come as tags in events.
    const others = Object.keys(tags.peek()).filter((name) => !all.some((each) => each.name === name));
    if (others.length) all = [...all, ...(await request('tags.list', { names: others })).tags];
    tagInfos.value = all;
    links.value = answer.links;
    tagsKnown.value = true;
  } catch (error) {
    complain(error);
  }
}

export function followTags(): () => void {
  const end = effect(() => {
    if (connected.value) void loadTags();
  });
  const timer = setInterval(() => {
    if (connected.peek()) void loadTags();
  }, kEvery);
  return () => {
    clearInterval(timer);
    end();
  };
}

/** The present properties: values of the event replace those of the list. */
export function tagNow(info: TagState): TagState {
  const live = tags.value[info.name];
  if (!live) return info;
  const since = live.since === null || live.since === undefined ? null : Number(live.since);
  const text = (live as { text?: string }).text ?? String(live.value);
  return { ...info, value: live.value, text, quality: live.quality, forced: live.forced, changed_by: live.by, changed_s: since };
}

export async function setTag(name: string, value: unknown): Promise<boolean> {
  try {
    await request('tags.set', { name, value });
    return true;
  } catch (error) {
    complain(error);
    return false;
  }
}

// --- forces: they last while this page renews them

const forces = new Map<string, () => void>();
/** Names of the tags that this page forces. */
export const forcedHere = signal<string[]>([]);

export async function forceTag(name: string, value: unknown): Promise<void> {
  releaseTag(name);
  try {
    const asked = stream('tags.force', { name, value }, () => undefined);
    forces.set(name, asked.stop);
    forcedHere.value = [...forces.keys()];
    asked.done.then(
      () => forget(name),
      (error) => {
        if (forces.has(name)) complain(error);
        forget(name);
      },
    );
  } catch (error) {
    complain(error);
  }
}
export function releaseTag(name: string): void {
  forces.get(name)?.();
  forget(name);
}
function forget(name: string): void {
  forces.delete(name);
  forcedHere.value = [...forces.keys()];
}
effect(() => {
  if (connected.value) return;
  forces.clear();
  forcedHere.value = [];
});
