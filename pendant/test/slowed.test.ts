import { describe, expect, it, vi } from 'vitest';

vi.stubGlobal('navigator', { language: 'en', userAgent: '' });
const { slowedWords } = await import('../src/view3d/slowed');

const near = (pace: number, a: string, b: string) => ({ a, b, pace, distance: 0.0421, kept: 0.02, onA: [0, 0, 0] as [number, number, number], onB: [0, 0, 0] as [number, number, number] });
const robots = ['left', 'right'];

describe('a planned move that is slower than planned', () => {
  it('is not told while it keeps its pace', () => {
    expect(slowedWords([near(1, 'left/forearm_link', 'fixture table')], robots, true)).toBe('');
  });
  it('says what it is near to', () => {
    expect(slowedWords([near(0.4, 'left/forearm_link', 'fixture table')], robots, true)).toBe('Slowed down: left/forearm_link is 42 mm from table');
    expect(slowedWords([near(0, 'left/forearm_link', 'fixture table')], robots, true)).toBe('Held 42 mm before table: left/forearm_link');
  });
  it('says which robot waits for which', () => {
    expect(slowedWords([near(0, 'left/forearm_link', 'right/wrist_3_link')], robots, true)).toBe('left waits for right: 42 mm between left/forearm_link and right/wrist_3_link');
    expect(slowedWords([near(0, 'left/forearm_link', 'right/wrist_3_link')], robots, false)).toBe('Held 42 mm before right/wrist_3_link: left/forearm_link');
    expect(slowedWords([near(0, 'left/forearm_link', 'left/base_link')], robots, true)).toBe('Held 42 mm before left/base_link: left/forearm_link');
  });
  it('names a robot that stands before one that is only slow', () => {
    expect(slowedWords([near(0.5, 'left/forearm_link', 'fixture table'), near(0, 'right/wrist_1_link', 'left/tool')], robots, true)).toMatch(/^right waits for left/);
  });
});
