import { describe, expect, it, vi } from 'vitest';

vi.stubGlobal('navigator', { language: 'en', userAgent: '' });
const { recordWords, sizeText } = await import('../src/pages/plots/recording');

const facts = { recording: true, file: '/cells/press/.state/recordings/run_3.mcap', seconds: 75.2, rate: 100, messages: 900, bytes: 3_400_000, lost: 0, problem: '' };

describe('a recording', () => {
  it('is reported with its file, time and size', () => {
    expect(recordWords(facts)).toBe('Recording run_3.mcap: 1:15, 3.4 MB');
    expect(recordWords({ ...facts, recording: false })).toBe('Recorded run_3.mcap: 1:15, 3.4 MB');
  });
  it('says what the disk was too slow for', () => {
    expect(recordWords({ ...facts, lost: 12 })).toBe('Recording run_3.mcap: 1:15, 3.4 MB · 12 cycles lost: the disk is too slow');
  });
  it('has its size in kB until it is a MB', () => {
    expect([sizeText(0), sizeText(1), sizeText(12_345), sizeText(1_000_000)]).toEqual(['0 kB', '1 kB', '13 kB', '1.0 MB']);
  });
});
