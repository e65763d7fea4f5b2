/** Which points are chosen, and how the list is narrowed and ordered. */
import { computed, effect, signal } from '@preact/signals';
import { type DataValue, isPlace, values } from '../../state/points';
import { chosenPoints } from '../../state/preview';

export const chosen = signal<string[]>([]);
export const query = signal('');
export const shownKind = signal<'points' | 'data'>('points');

effect(() => {
  chosenPoints.value = chosen.value;
});

/** Those whose name, group, file or text has every word of `words`. */
export function found(all: DataValue[], words: string): DataValue[] {
  const wanted = words.toLowerCase().split(/\s+/).filter(Boolean);
  return all.filter((each) => {
    const text = `${each.name} ${each.group} ${each.file} ${each.taught?.frame ?? ''}`.toLowerCase();
    return wanted.every((word) => text.includes(word));
  });
}

/** By group (those without one last, under their file), in the order of the file. */
export function grouped(list: DataValue[]): { title: string; group: boolean; values: DataValue[] }[] {
  const out = new Map<string, { title: string; group: boolean; values: DataValue[] }>();
  for (const each of [...list.filter((v) => v.group), ...list.filter((v) => !v.group)]) {
    const key = each.group ? `g${each.group}` : `f${each.file}`;
    if (!out.has(key)) out.set(key, { title: each.group || each.file, group: each.group !== '', values: [] });
    out.get(key)!.values.push(each);
  }
  return [...out.values()];
}

export const shown = computed(() =>
  grouped(found(values.value.filter((each) => isPlace(each.kind) === (shownKind.value === 'points')), query.value)),
);
export const chosenValues = computed(() => values.value.filter((each) => chosen.value.includes(each.name)));

export function choose(name: string, more: boolean): void {
  if (!more) chosen.value = [name];
  else chosen.value = chosen.value.includes(name) ? chosen.value.filter((each) => each !== name) : [...chosen.value, name];
}
