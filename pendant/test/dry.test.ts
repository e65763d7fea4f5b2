// What a dry run is called.
import { describe, expect, it, vi } from 'vitest';

vi.stubGlobal('navigator', { language: 'en', userAgent: '' });
vi.stubGlobal('matchMedia', () => ({ matches: false, addEventListener: () => undefined }));
vi.stubGlobal('location', { hash: '', protocol: 'http:', host: 'localhost' });
vi.stubGlobal('addEventListener', () => undefined);
const { dryWords } = await import('../src/pages/program/dry');

const found = (code: string, severity: 'error' | 'warning' = 'error') => ({ code, severity, what: '', advice: '', file: '', line: 1, column: 1 });
const whole = { checked: true, unchecked: [], seconds: 12, whole: true };

describe('a dry run', () => {
  const title = (...problems: ReturnType<typeof found>[]) => dryWords({ problems, moves: 3, contacts: whole }).title;
  it('is called by the worst that it found', () => {
    expect(title()).toBe('program.dryGood');
    expect(title(found('clearance', 'warning'))).toBe('program.dryGood');
    expect(title(found('guard'))).toBe('program.dryNear');
    expect(title(found('guard'), found('contact'))).toBe('program.dryContact');
    expect(title(found('unreachable'))).toBe('program.dryBad');
    expect(dryWords({ problems: [found('unknown-name')], moves: 0, contacts: whole }).title).toBe('program.dryNothing');
  });
  it('is not called good where nothing looked for contacts, and says how far something did', () => {
    const blind = dryWords({ problems: [], moves: 3, contacts: { checked: false, unchecked: ["arm: its hardware is 'mock'"], seconds: 0, whole: false } });
    expect(blind).toEqual({ title: 'program.dryBlind', until: null, unchecked: "arm: its hardware is 'mock'" });
    expect(dryWords({ problems: [], moves: 3, contacts: { ...whole, seconds: 40, whole: false } }).until).toBe(40);
    expect(dryWords({ problems: [], moves: 3, contacts: whole }).until).toBe(null);
  });
});
