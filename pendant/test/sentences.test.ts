import { describe, expect, it, vi } from 'vitest';

vi.stubGlobal('navigator', { language: 'en', userAgent: '' });
const { kindsIn, sentenceOf } = await import('../src/pages/program/sentence');
const { statementsOf } = await import('../src/pages/program/statements');

const names = [{ name: 'Dock', kind: 'pose' }, { name: 'bay 3', kind: 'pose' }, { name: 'Distance', kind: 'number' }];
const said = (line: string, before = '') => {
  const all = statementsOf(`${before}\n${line}`);
  return sentenceOf(all.at(-1)!, kindsIn(all, names));
};

describe('sentences of bases', () => {
  it('say whether the base drives by a length or to a pose, with its clauses', () => {
    expect(said('drive 500mm, speed 0.2m/s')).toMatchObject({ text: 'Drive 500mm', chips: ['speed 0.2m/s'] });
    expect(said('drive -300mm').text).toBe('Drive -300mm');
    expect(said('drive Dock, frame table')).toMatchObject({ text: 'Drive to Dock', chips: ['frame table'] });
    expect(said('drive pose(1m, 2m, rz = 90deg)').text).toBe('Drive to pose(1m, 2m, rz = 90deg)');
  });
  it('say a length where a name is a number, or unknown', () => {
    expect(said('drive Distance').text).toBe('Drive Distance');
    expect(said('drive Distance * 2').text).toBe('Drive Distance * 2');
    expect(said('drive d', 'let d = 500mm').text).toBe('Drive d');
    expect(said('drive Dock', 'let Dock = 300mm').text).toBe('Drive Dock');
  });
  it('say a pose where the program names one, or where its name is in quotes', () => {
    expect(said('drive bay', 'let bay = offset(Dock, x = 1m)').text).toBe('Drive to bay');
    expect(said('drive `bay 3`').text).toBe('Drive to `bay 3`');
  });
});
