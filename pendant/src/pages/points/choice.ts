/** The chosen points, and how the list is filtered and ordered. */
import { computed, effect, signal } from '@preact/signals';
import { t } from '../../i18n';
import { type DataValue, groupNames, isPlace, isTool, values } from '../../state/points';
import { chosenPoints } from '../../state/preview';
import { kept } from '../../state/settings';

export const chosen = signal<string[]>([]);
export const query = signal('');
export const shownKind = signal<'points' | 'data'>('points');
/** The name of the only group to show; null: all groups; an empty text: points without a group. */
const wantedGroup = signal<string | null>(null);
export const shownGroup = computed(() => {
  const name = wantedGroup.value;
  return name === null || name === '' || groupNames.value.includes(name) ? name : null;
});
export const showGroup = (name: string | null) => (wantedGroup.value = name);
/** Keys of folded groups, whose points are hidden. A search shows their points too. */
export const folded = kept<string[]>('points.folded', []);
export function fold(key: string): void {
  folded.value = folded.value.includes(key) ? folded.value.filter((each) => each !== key) : [...folded.value, key];
}

effect(() => {
  chosenPoints.value = chosen.value;
});

/** The values whose name, group, file or frame contains every word of `words`. */
export function found(all: DataValue[], words: string): DataValue[] {
  const wanted = words.toLowerCase().split(/\s+/).filter(Boolean);
  return all.filter((each) => {
    const text = `${each.name} ${each.group} ${each.file} ${each.taught?.frame ?? ''}`.toLowerCase();
    return wanted.every((word) => text.includes(word));
  });
}

export interface PointGroup {
  key: string;
  title: string;
  kind: 'group' | 'file' | 'tools';
  values: DataValue[];
}
/** Values by group, then those without a group by file, then tools. */
export function grouped(list: DataValue[], toolsTitle: string): PointGroup[] {
  const out = new Map<string, PointGroup>();
  const kindOf = (each: DataValue) => (isTool(each) ? 'tools' : each.group ? 'group' : 'file');
  for (const kind of ['group', 'file', 'tools'] as const)
    for (const each of list.filter((value) => kindOf(value) === kind)) {
      const title = kind === 'tools' ? toolsTitle : kind === 'group' ? each.group : each.file;
      const key = `${kind[0]}${kind === 'tools' ? '' : title}`;
      if (!out.has(key)) out.set(key, { key, title, kind, values: [] });
      out.get(key)!.values.push(each);
    }
  return [...out.values()];
}

export const shown = computed(() => {
  const only = shownGroup.value;
  const list = values.value.filter((each) => isPlace(each.kind) === (shownKind.value === 'points') && (only === null || each.group === only));
  return grouped(found(list, query.value), t('points.tools'));
});
export const chosenValues = computed(() => values.value.filter((each) => chosen.value.includes(each.name)));

/** Selects the whole group, or deselects it if all its points were selected. */
export function chooseAll(group: PointGroup): void {
  const names = group.values.map((each) => each.name);
  const rest = chosen.value.filter((each) => !names.includes(each));
  chosen.value = names.every((each) => chosen.value.includes(each)) ? rest : [...rest, ...names];
}

export function choose(name: string, more: boolean): void {
  if (!more) chosen.value = [name];
  else chosen.value = chosen.value.includes(name) ? chosen.value.filter((each) => each !== name) : [...chosen.value, name];
}
