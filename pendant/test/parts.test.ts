import { describe, expect, it } from 'vitest';
import { partsDone } from '../src/pages/run/parts';
import { readPart, readScene } from '../src/wire/read';

const pose = (x: number) => ({ p: [x, 0, 0.02], q: [0, 0, 0, 1] });
const bin = (name: string, x: number) => ({ name, lower: [x - 0.05, -0.05, 0], upper: [x + 0.05, 0.05, 0.06] });
const scene = (parts: object[]) => readScene({ fixtures: [], parts, bins: [bin('from', 0), bin('middle', 0.3), bin('to', 0.6)], movers: [] }).things;
const at = (name: string, x: number, more = {}) => readPart({ name, ...pose(x), in_world: true, held_by: null, ...more });
const done = (parts: ReturnType<typeof at>[], things: ReturnType<typeof scene>) => partsDone(parts, things).done;

describe('parts that are done', () => {
  it('does not count parts in the bin in which they began', () => {
    const things = scene([{ name: 'blank', pose: pose(0), visuals: [] }]);
    expect(partsDone([at('blank', 0)], things)).toEqual({ done: 0, all: 1 });
    expect(done([at('blank', 0.6)], things)).toBe(1);
    expect(done([at('blank', 0.6, { held_by: 'arm' })], things)).toBe(0);
  });
  it('lie in the bin of their goal, where the scene names one', () => {
    const things = scene([{ name: 'blank', pose: pose(0), visuals: [], goal: { at: [0.6, 0, 0.02], bin: 'to' } }]);
    expect(done([at('blank', 0.3)], things)).toBe(0);
    expect(done([at('blank', 0.6)], things)).toBe(1);
  });
  it('come out of a feeder into any bin, or were taken away', () => {
    const things = scene([{ name: 'cube', pose: pose(0), feeder: 'feeder', goal: null, visuals: [] }]);
    expect(done([at('cube', 0)], things)).toBe(1);
    expect(done([at('cube', 9, { in_world: false })], things)).toBe(0);
    expect(done([at('cube', 9, { in_world: false, taken: true })], things)).toBe(1);
  });
});
