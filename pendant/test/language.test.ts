// English comes with the page; another language comes when it is chosen.
import { expect, it, vi } from 'vitest';

vi.stubGlobal('navigator', { language: 'es-MX', userAgent: '' });
const sources = import.meta.glob('../src/**/*.{ts,tsx}', { query: '?raw', import: 'default', eager: true }) as Record<string, string>;

/** The file that `from` means in an import of `file`; undefined for a package or a style. */
function fileOf(file: string, from: string): string | undefined {
  if (!from.startsWith('.')) return undefined;
  const parts = file.split('/').slice(0, -1);
  for (const part of from.split('/'))
    if (part === '..' && parts.at(-1) !== '..') parts.pop();
    else if (part !== '.') parts.push(part);
  const path = parts.join('/');
  return [`${path}.ts`, `${path}.tsx`, `${path}/index.ts`, `${path}/index.tsx`].find((each) => each in sources);
}

it('keeps Spanish out of the first chunk', () => {
  const first = new Set(['../src/main.tsx']);
  for (const file of first)
    for (const [, from] of sources[file]!.matchAll(/^(?:import|export)(?! type)[^;]*?'(\.[^']+)';/gm)) {
      const to = fileOf(file, from!);
      if (to) first.add(to);
    }
  expect(first).toContain('../src/i18n/en/codes.ts');
  expect([...first].filter((file) => file.includes('/i18n/es'))).toEqual([]);
});

it('speaks English, numbers too, until the wanted table is there', async () => {
  const { language, languageLoaded, number, t } = await import('../src/i18n');
  expect([language.value, t('bar.resume'), number(-1.5, 1)]).toEqual(['en', 'Resume', '−1.5']);
  await languageLoaded();
  expect([language.value, t('bar.resume'), number(-1.5, 1)]).toEqual(['es', 'Reanudar', '−1,5']);
});

it('does not wait for a table that does not come', async () => {
  vi.resetModules();
  vi.doMock('../src/i18n/es', () => new Promise(() => undefined));
  vi.useFakeTimers();
  const { language, languageTried } = await import('../src/i18n');
  let over = false;
  const tried = languageTried(2000).then(() => (over = true));
  await vi.advanceTimersByTimeAsync(1000);
  expect(over).toBe(false);
  await vi.advanceTimersByTimeAsync(1500);
  await tried;
  expect([over, language.value]).toEqual([true, 'en']);
  vi.useRealTimers();
  expect(sources['../src/main.tsx']).toMatch(/languageTried\(\d+\)\.then\(\(\) => render\(/);
});
