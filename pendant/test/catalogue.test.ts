import { describe, expect, it } from 'vitest';
import { axesOf, type CatalogueEntry, fitting, kNoWish, makersOf } from '../src/pages/cell/robots';

const robot = (id: string, axes: number, reach: number | null, payload: number | null): CatalogueEntry => ({
  id, maker: id.split('/')[0]!, model: id.split('/')[1]!, title: id.replace('/', ' '), axes, reach, payload,
});
const all = [robot('abb/irb_120', 6, 0.58, 3), robot('universal_robots/ur3', 6, 0.5, 3), robot('franka/fr3', 7, 0.855, 3), robot('demo/old', 6, null, null), robot('abb/irb_1200', 6, 0.9, 7)];
const ids = (wish: Partial<typeof kNoWish>) => fitting(all, { ...kNoWish, ...wish }).map((each) => each.id);

describe('fitting', () => {
  it('finds by parts of names, however they are written', () => {
    expect(ids({ words: 'irb120' })).toEqual(['abb/irb_120', 'abb/irb_1200']);
    expect(ids({ words: 'Universal ur3' })).toEqual(['universal_robots/ur3']);
    expect(ids({ words: 'nothing' })).toEqual([]);
  });
  it('by maker and axes', () => {
    expect(ids({ maker: 'abb' })).toEqual(['abb/irb_120', 'abb/irb_1200']);
    expect(ids({ axes: '7' })).toEqual(['franka/fr3']);
  });
  it('at least so far and so much; who has no figure does not fit', () => {
    expect(ids({ reach: '0.58' })).toEqual(['abb/irb_120', 'franka/fr3', 'abb/irb_1200']);
    expect(ids({ payload: '5' })).toEqual(['abb/irb_1200']);
  });
  it('in order, those without a figure last', () =>
    expect(ids({ order: 'reach' })).toEqual(['universal_robots/ur3', 'abb/irb_120', 'franka/fr3', 'abb/irb_1200', 'demo/old']));
  it('tells what can be chosen', () => {
    expect(makersOf(all)).toEqual(['abb', 'demo', 'franka', 'universal_robots']);
    expect(axesOf(all)).toEqual([6, 7]);
  });
});
