// What the wizards have recorded belongs to one robot of one cell.
import { describe, expect, it, vi } from 'vitest';

vi.stubGlobal('navigator', { language: 'en', userAgent: '' });
const { cell, robotName } = await import('../src/state/cell');
const { ofRobot } = await import('../src/pages/points/samples');

const open = (folder: string, ...robots: [string, string][]) => (cell.value = { folder, robots: robots.map(([name, id]) => ({ name, id })) } as unknown as typeof cell.value);

it('does not mix the samples of two robots, nor those of two cells', () => {
  const poses = ofRobot<number[]>([]);
  open('/cells/a', ['left', 'ur/ur5e'], ['right', 'fanuc/lrmate']);
  poses.value = [1, 2];
  robotName.value = 'right';
  expect(poses.value).toEqual([]);
  poses.value = [3];
  robotName.value = 'left';
  expect(poses.value).toEqual([1, 2]);
  open('/cells/b', ['left', 'ur/ur5e']);
  expect(poses.value).toEqual([]);
  open('/cells/a', ['left', 'ur/ur10e'], ['right', 'fanuc/lrmate']);
  expect(poses.value).toEqual([]);
  open('/cells/a', ['left', 'ur/ur5e']);
  expect(poses.value).toEqual([1, 2]);
});

it('gives an answer that comes late to the robot that was asked', () => {
  const poses = ofRobot<number[]>([]);
  open('/cells/a', ['left', 'ur/ur5e'], ['right', 'fanuc/lrmate']);
  robotName.value = 'left';
  const mine = poses.mine();
  robotName.value = 'right';
  poses.value = [9];
  mine.value = [...mine.value, 1];
  expect(poses.value).toEqual([9]);
  robotName.value = 'left';
  expect([poses.value, mine.value]).toEqual([[1], [1]]);
});

it('lets every wizard write an answer of the cell through the robot that was asked', () => {
  const wizards = import.meta.glob('../src/pages/points/*Wizard.tsx', { query: '?raw', import: 'default', eager: true }) as Record<string, string>;
  expect(Object.keys(wizards).length).toBe(5);
  for (const text of Object.values(wizards)) {
    expect(text.match(/(?:touches|toolPoses|sightings|weighings|armPoses)\.mine\(\)/g)?.length).toBe(2);
    expect(text).not.toMatch(/(?:\.then\(.*|\[)(?:touches|toolPoses|sightings|weighings|armPoses)\.value/);
    expect(text).toMatch(/disabled=\{saving \|\|/);
  }
});

describe('what the wizards say of the poses', () => {
  const down = [1, 0, 0, 0] as const, up = [0, 0, 0, 1] as const, half = Math.SQRT1_2;
  it('names where the hand points', async () => {
    const { fromDown, pointing } = await import('../src/pages/points/directions');
    expect(fromDown([...down])).toBeCloseTo(0);
    expect(fromDown([half, 0, 0, half])).toBeCloseTo(Math.PI / 2);
    expect(pointing([...down])).toBe('the hand points down');
    expect(pointing([...up])).toBe('the hand points up');
    expect(pointing([0, half, 0, half])).toBe('the hand points 90° from down');
  });
  it('names the joints that have hardly turned, and none that slides', async () => {
    const { hardlyTurned } = await import('../src/pages/points/directions');
    const joints = [{ name: 'base', unit: 'rad' }, { name: 'elbow', unit: 'rad' }, { name: 'rail', unit: 'm' }];
    expect(hardlyTurned([], 1, joints)).toEqual([]);
    expect(hardlyTurned([{ base: 0, elbow: -1, rail: 0 }, { base: 0.9, elbow: 0.5, rail: 0.8 }], 1, joints)).toEqual(['base']);
  });
});
