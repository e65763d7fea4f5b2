/** Settings that this browser stores: how the page looks, never the cell itself. */
import { effect, signal, type Signal } from '@preact/signals';

const kPrefix = 'polyarm.';

/** A signal whose value this browser stores. */
export function kept<T>(name: string, fallback: T): Signal<T> {
  let first = fallback;
  try {
    const text = localStorage.getItem(kPrefix + name);
    if (text !== null) first = JSON.parse(text) as T;
  } catch {
    // No storage or invalid content: the fallback applies.
  }
  const out = signal(first);
  effect(() => {
    const text = JSON.stringify(out.value);
    try {
      localStorage.setItem(kPrefix + name, text);
    } catch {
      // The storage of a private window may be disabled; the page works without it.
    }
  });
  return out;
}

export type Theme = 'auto' | 'light' | 'dark';
export type Language = 'auto' | 'en' | 'es';

function deviceName(): string {
  const agent = navigator.userAgent;
  const kind = /iPad|Tablet|Android(?!.*Mobile)/.test(agent)
    ? 'Tablet'
    : /iPhone|Mobile/.test(agent)
      ? 'Phone'
      : 'Browser';
  return `${kind} ${Math.floor(10 + 90 * Math.random())}`;
}

export const settings = {
  theme: kept<Theme>('theme', 'auto'),
  language: kept<Language>('language', 'auto'),
  clientName: kept<string>('clientName', deviceName()),
  takeWhenFree: kept<boolean>('takeWhenFree', true),
  degrees: kept<boolean>('degrees', true),
  leftHanded: kept<boolean>('leftHanded', false),
};

export const darkNow = signal(true);

export function startTheme(): void {
  const system = matchMedia('(prefers-color-scheme: dark)');
  const systemDark = signal(system.matches);
  system.addEventListener('change', () => (systemDark.value = system.matches));
  effect(() => {
    document.documentElement.dataset.hand = settings.leftHanded.value ? 'left' : 'right';
  });
  effect(() => {
    const theme = settings.theme.value;
    const dark = theme === 'dark' || (theme === 'auto' && systemDark.value);
    darkNow.value = dark;
    document.documentElement.dataset.theme = dark ? 'dark' : 'light';
    document.querySelector('meta[name=theme-color]')?.setAttribute('content', dark ? '#10151c' : '#ffffff');
  });
}
