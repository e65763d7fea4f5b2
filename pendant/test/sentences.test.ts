import { describe, expect, it, vi } from 'vitest';

vi.stubGlobal('navigator', { language: 'en', userAgent: '' });
const { sentenceOf } = await import('../src/pages/program/sentence');
const { statementsOf } = await import('../src/pages/program/statements');

const said = (line: string) => sentenceOf(statementsOf(line)[0]!);

describe('sentences of bases', () => {
  it('say whether the base drives by a length or to a pose, with its clauses', () => {
    expect(said('drive 500mm, speed 0.2m/s')).toMatchObject({ text: 'Drive 500mm', chips: ['speed 0.2m/s'] });
    expect(said('drive -300mm').text).toBe('Drive -300mm');
    expect(said('drive Dock, frame table')).toMatchObject({ text: 'Drive to Dock', chips: ['frame table'] });
    expect(said('drive pose(1m, 2m, rz = 90deg)').text).toBe('Drive to pose(1m, 2m, rz = 90deg)');
  });
});
