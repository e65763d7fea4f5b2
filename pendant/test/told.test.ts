// What the cell says for terminals, as the page says it.
import { beforeEach, describe, expect, it, vi } from 'vitest';
import supervisor from '../../polyarm/control/supervisor.cpp?raw';

vi.stubGlobal('navigator', { language: 'en', userAgent: '' });
const { causes, causeWords, plain, problemWords } = await import('../src/i18n/told');
const { settings } = await import('../src/state/settings');
const sources = import.meta.glob('../../polyarm/{cell,server,motion,control,data,signals}/*.cpp', { query: '?raw', import: 'default', eager: true }) as Record<string, string>;

beforeEach(() => {
  settings.language.value = 'en';
});

describe('what the cell tells', () => {
  it('has every cause of a stop in both languages', () => {
    const list = /const char\* name\(StopCause cause\) \{([^}]*\})/.exec(supervisor)?.[1] ?? '';
    const told = [...list.matchAll(/"([^"]+)"/g)].map((found) => found[1]!).filter((cause) => cause !== 'nothing');
    expect(told.length).toBeGreaterThan(10);
    for (const cause of told) {
      expect(causes.filter(([beginning]) => beginning.test(cause)).length, cause).toBeGreaterThan(0);
      settings.language.value = 'en';
      const english = causeWords(cause);
      settings.language.value = 'es';
      expect(causeWords(cause), cause).not.toBe(english);
    }
  });

  it('never advises to type a command', () => {
    const texts = Object.values(sources).flatMap((text) => [...text.matchAll(/"((?:[^"\\]|\\.)*\bpolyarm (?:control|run|hardware|tags)\b(?:[^"\\]|\\.)*)"/g)].map((found) => found[1]!));
    expect(texts.length).toBeGreaterThan(20);
    for (const text of [...texts, "let it go back; or discard the motion; or resume with --anyway"]) {
      expect(plain(text), text).not.toMatch(/\bpolyarm [a-z]|--[a-z]/);
      expect(problemWords({ code: 'whatever', what: 'It failed', advice: text }).advice, text).not.toMatch(/\bpolyarm [a-z]|--[a-z]/);
    }
  });

  it('keeps what is no command', () => {
    expect(plain('main.script:3: error: no way there (move the point)')).toBe('main.script:3: error: no way there (move the point)');
    expect(plain('it is held (go on: polyarm control resume; or wait)')).toBe('it is held (wait)');
    expect(plain('let it go back; or resume with --anyway')).toBe('let it go back');
    expect(plain('polyarm control arm')).toBe('');
    for (const text of ['the mesh /tmp/polyarm-cells/own/a.stl is no whole STL (export it again)', 'another polyarm runs this cell: process 12'])
      expect(plain(text)).toBe(text);
  });

  it('says a problem by its code, and what the cell says of it below', () => {
    const problem = { code: 'motion-held', what: "'arm' is not jogged", advice: 'go on: polyarm control resume' };
    expect(problemWords(problem)).toEqual({ text: "'arm' is not jogged", detail: '', advice: 'Press Resume, or Cancel motion' });
    settings.language.value = 'es';
    expect(problemWords(problem)).toEqual({ text: 'Hay un movimiento en pausa a medio camino', detail: "'arm' is not jogged", advice: 'Pulse Reanudar o Cancelar movimiento' });
  });
});
