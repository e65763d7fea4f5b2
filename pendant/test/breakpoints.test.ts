import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { BreakpointKeeper, lineMap } from '../src/pages/program/breakpoints';

const kText = 'a\nwait 1\nb\nwait 1\nc';

describe('lineMap', () => {
  const all = (after: string) => [1, 2, 3, 4, 5].map(lineMap(kText, after));
  it('goes down with lines that come above', () => expect(all('x\na\nwait 1\ny\nb\nwait 1\nc')).toEqual([2, 3, 5, 6, 7]));
  it('knows what is gone', () => expect(all('a\nwait 1\nc')).toEqual([1, 2, 0, 0, 3]));
  it('finds again what was moved, there and back', () => {
    const [first, second] = ['x\ny\nz', 'y\nx\nz'];
    expect([1, 2, 3].map(lineMap(first, second))).toEqual([2, 1, 3]);
    expect([1, 2, 3].map(lineMap(second, first))).toEqual([2, 1, 3]);
  });
  it('stays where a line is written anew', () => expect(all('a\nwait 2\nb\nwait 1\nc')).toEqual([1, 2, 3, 4, 5]));
});

describe('BreakpointKeeper', () => {
  let shown: number[] = [];
  let asked: unknown[][] = [];
  let answers: ((lines: number[]) => void)[] = [];
  const make = () => {
    const answer = (...args: unknown[]) => {
      asked.push(args);
      return new Promise<number[]>((done) => answers.push(done));
    };
    return new BreakpointKeeper({ tell: answer, toggle: answer, onLines: (lines) => (shown = lines) });
  };
  const answered = async (lines: number[]) => {
    answers.shift()!(lines);
    await vi.advanceTimersByTimeAsync(0);
  };
  beforeEach(() => {
    vi.useFakeTimers();
    [shown, asked, answers] = [[], [], []];
  });
  afterEach(() => void vi.useRealTimers());

  it('tells text and lines again when it is asked to', async () => {
    const keeper = make();
    keeper.retell();
    expect(asked).toEqual([]);
    keeper.open('job.script', kText, [2]);
    await answered([2]);
    keeper.retell();
    expect(asked[1]).toEqual(['job.script', kText, [2]]);
  });
  it('tells the text that is opened, so that the cell finds its breakpoints in it', async () => {
    const keeper = make();
    keeper.open('job.script', kText, [2]);
    expect(asked).toEqual([['job.script', kText]]);
    await answered([4]);
    expect(shown).toEqual([4]);
    keeper.heard([1, 4]);
    expect(shown).toEqual([1, 4]);
  });

  it('asks nothing of a file without any', () => {
    const keeper = make();
    keeper.open('job.script', kText, []);
    keeper.edited('x');
    vi.advanceTimersByTime(1000);
    expect(asked).toEqual([]);
  });

  it('moves them while it is written, and does not take what the cell said of the text before', async () => {
    const keeper = make();
    keeper.open('job.script', kText, []);
    keeper.heard([3]);
    keeper.edited(`x\n${kText}`);
    expect(shown).toEqual([4]);
    keeper.heard([3]);
    expect(shown).toEqual([4]);
    vi.advanceTimersByTime(300);
    expect(asked).toEqual([['job.script', `x\n${kText}`, [4]]]);
    keeper.edited(`x\ny\n${kText}`);
    await answered([4]);
    expect(shown).toEqual([5]);
    vi.advanceTimersByTime(300);
    await answered([6]);
    expect(shown).toEqual([6]);
  });

  it('goes by what the editor knows, and forgets a line that is gone', () => {
    const keeper = make();
    keeper.open('job.script', kText, []);
    keeper.heard([2, 3]);
    keeper.edited('a\nwait 1\nwait 1\nb\nwait 1\nc', (line) => (line === 2 ? 3 : 0));
    expect(shown).toEqual([3]);
  });

  it('shows a breakpoint at once, and takes back what is refused', async () => {
    const keeper = new BreakpointKeeper({ tell: async () => [], toggle: async () => Promise.reject(new Error('no')), onLines: (lines) => (shown = lines) });
    keeper.open('job.script', kText, []);
    const done = keeper.toggle(5);
    expect(shown).toEqual([5]);
    await done;
    expect(shown).toEqual([]);
  });
});
