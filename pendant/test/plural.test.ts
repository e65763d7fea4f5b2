// Texts with a number have the word for one, too.
import { describe, expect, it, vi } from 'vitest';

vi.stubGlobal('navigator', { language: 'en', userAgent: '' });
const { languageLoaded, t } = await import('../src/i18n');
const { en } = await import('../src/i18n/en');
const { es } = await import('../src/i18n/es');
const { settings } = await import('../src/state/settings');

describe('a number in a text', () => {
  it('has its word in one and in many', async () => {
    settings.language.value = 'es';
    await languageLoaded();
    const said = (count: number) => ['en', 'es'].map((language) => ((settings.language.value = language as 'en' | 'es'), t('move.queued', { count })));
    expect(said(1)).toEqual(['1 step to go', 'falta 1 paso']);
    expect(said(3)).toEqual(['3 steps to go', 'faltan 3 pasos']);
  });
  it('is never followed by a plural alone', () => {
    // Counts from 1 to … of something that has many: the number is never 1.
    const kMany = new Set(['mesh.size', 'with.links-without-body', 'step.retry']);
    for (const [language, table] of [['en', en], ['es', es]] as const)
      for (const [key, text] of Object.entries(table))
        if (!kMany.has(key)) expect(text, `${language} ${key}`).not.toMatch(/\{(count|all|moves|axes|tags|losses|lost|clients|steps|rest)\} (?:[a-zéíóúñ]+ )?[a-zéíóúñ]{2,}s\b/);
  });
});
