import { describe, expect, it } from 'vitest';
import { bars, readHealth, readTimes } from '../src/wire/health';

describe('readTimes', () => {
  it('takes nanoseconds and microseconds', () => {
    expect(readTimes({ p50_ns: 1500, p99_ns: 2000, max_ns: 9000 })).toEqual({ p50: 1.5, p99: 2, max: 9, buckets: [] });
    expect(readTimes({ p50: 1, p99: 2, max: 3, buckets: [{ to_us: 4, count: 5 }] })!.buckets).toEqual([{ to: 4, count: 5 }]);
  });
  it('is nothing where nothing was timed', () => {
    expect(readTimes({ p50_ns: 0, p99_ns: 0, max_ns: 0 })).toBeNull();
    expect(readTimes(undefined)).toBeNull();
  });
});

describe('bars', () => {
  const buckets = [0, 0, 3, 5, 0, 2, 0].map((count, i) => ({ to: i + 1, count }));
  const times = { p50: 1, p99: 1, max: 6, buckets };
  it('begin and end where there is something', () =>
    expect(bars(times, 10)).toEqual([
      { from: 2, to: 3, count: 3 }, { from: 3, to: 4, count: 5 }, { from: 4, to: 5, count: 0 }, { from: 5, to: 6, count: 2 },
    ]));
  it('are put together where there are too many, and lose nothing', () => {
    const few = bars(times, 2);
    expect(few.length).toBe(2);
    expect(few.reduce((sum, each) => sum + each.count, 0)).toBe(10);
  });
});

describe('readHealth', () => {
  it('lives with what is missing', () => {
    const now = readHealth({ parts: [{ controller: 'a', turns: 3 }], threads: [{ component: 'b', runs: 4, missed: 1 }] });
    expect(now.parts.map((each) => [each.name, each.kind, each.turns, each.missed])).toEqual([['a', 'controller', 3, 0], ['b', 'component', 4, 1]]);
    expect([now.cost, now.fallen]).toEqual([null, []]);
  });
});
