import {describe, expect, it, vi} from 'vitest';

vi.stubGlobal('navigator', {language: 'en', userAgent: ''});
const {mode} = await import('../src/pages/program/mode');
const {knownWords} = await import('../src/pages/program/knownWords');

describe('the language of the editor', () => {
  it('is made once for a list of words, as CodeMirror never forgets one', () => {
    expect(mode(knownWords)).toBe(mode(knownWords));
    expect(mode({...knownWords})).not.toBe(mode(knownWords));
  });
});
