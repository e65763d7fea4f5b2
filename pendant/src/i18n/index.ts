/**
 * One table per language, in parts by page. The type checker rejects a language with a missing key. English is part of the
 * page; the other tables are loaded when their language is chosen.
 */
import { computed, effect, signal } from '@preact/signals';
import { settings } from '../state/settings';
import { en } from './en';

export type Key = keyof typeof en;
type Table = Record<Key, string>;
const kLoads = { es: () => import('./es').then(({ es }): Table => es) };
const loaded = signal<{ es?: Table }>({});

export const languages = [
  { id: 'en', name: 'English' },
  { id: 'es', name: 'Español' },
] as const;

/** What the user or the browser wants. */
const wanted = computed<'en' | 'es'>(() => {
  const chosen = settings.language.value;
  if (chosen !== 'auto') return chosen;
  return navigator.language?.toLowerCase().startsWith('es') ? 'es' : 'en';
});

/** The language of the page: the wanted one once its table is there, until then English. */
export const language = computed<'en' | 'es'>(() => (wanted.value === 'es' && loaded.value.es ? 'es' : 'en'));

/** Loads the table of the wanted language, if the page lacks it. */
export async function languageLoaded(): Promise<void> {
  const id = wanted.value;
  if (id === 'en' || loaded.peek()[id]) return;
  const table = await kLoads[id]();
  loaded.value = { ...loaded.peek(), [id]: table };
}
/** Ends when the table is there or cannot be had, at the latest after `ms`: a page without words would have no Stop. */
export async function languageTried(ms: number): Promise<void> {
  const late = new Promise<void>((end) => setTimeout(end, ms));
  await Promise.race([languageLoaded().catch(() => undefined), late]);
}
effect(() => void languageLoaded().catch(() => undefined));

/** The text of `key`, with {names} filled in. `{count:step|steps}` is the first word if `count` is 1, else the second. */
export function t(key: Key, values: Record<string, string | number> = {}): string {
  const now = language.value;
  const text = (now === 'en' ? en : loaded.value[now]!)[key] ?? en[key];
  return text.replace(/\{(\w+):([^{}|]*)\|([^{}|]*)\}/g, (_, name: string, one: string, more: string) => (Number(values[name]) === 1 ? one : more)).replace(/\{(\w+)\}/g, (whole, name: string) => (name in values ? String(values[name]) : whole));
}

/** The text of a word of the cell (`state.running`), or the word itself if no table has it. */
export function word(prefix: string, value: string): string {
  const key = `${prefix}.${value}` as Key;
  return key in en ? t(key) : value;
}

/**
 * A date and time (s since 1970), in the format of the browser's user if the browser has the page's language,
 * else in the format of the page's language.
 */
export function moment(seconds: number): string {
  const own = navigator.language?.toLowerCase().startsWith(language.value);
  return new Date(1000 * seconds).toLocaleString(own ? navigator.language : language.value, { dateStyle: 'medium', timeStyle: 'short' });
}

/** A number in the format of the page's language. */
export function number(value: number, digits: number): string {
  if (!Number.isFinite(value)) return '–';
  const text = value.toFixed(digits);
  const positive = Number(text) === 0 ? text.replace('-', '') : text;
  return language.value === 'es' ? positive.replace('.', ',').replace('-', '−') : positive.replace('-', '−');
}
