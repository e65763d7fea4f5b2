/** One table per language, in parts by page. The type checker rejects a language with a missing key. */
import { computed } from '@preact/signals';
import { settings } from '../state/settings';
import { en } from './en';
import { es } from './es';

export type Key = keyof typeof en;
const tables: Record<string, Record<Key, string>> = { en, es };

export const languages = [
  { id: 'en', name: 'English' },
  { id: 'es', name: 'Español' },
] as const;

export const language = computed<'en' | 'es'>(() => {
  const chosen = settings.language.value;
  if (chosen !== 'auto') return chosen;
  return navigator.language?.toLowerCase().startsWith('es') ? 'es' : 'en';
});

/** The text of `key`, with {names} filled in. `{count:step|steps}` is the first word if `count` is 1, else the second. */
export function t(key: Key, values: Record<string, string | number> = {}): string {
  const text = tables[language.value]?.[key] ?? en[key];
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
