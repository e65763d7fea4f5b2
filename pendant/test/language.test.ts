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
