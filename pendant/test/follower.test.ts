import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { Follower, kEveryMs, kGoodForS } from '../src/wire/follower';
import type { Json } from '../src/wire/connection';

let asked: { args: Json; answer: (a: Json) => void; refuse: (e: unknown) => void }[];
let ends: unknown[];
let follower: Follower;

beforeEach(() => {
  vi.useFakeTimers();
  [asked, ends] = [[], []];
  follower = new Follower(
    <T>(_: string, args: Json) =>
      new Promise<T>((resolve, reject) => asked.push({ args, answer: (a) => resolve(a as T), refuse: reject })),
    (error) => ends.push(error),
  );
});
afterEach(() => void vi.useRealTimers());

/** Time goes by while everything is answered at once. */
async function answered(ms: number, session = 4): Promise<void> {
  for (let gone = 0; gone < ms; gone += 10) {
    await vi.advanceTimersByTimeAsync(10);
    for (const each of asked) each.answer({ session });
  }
}

describe('a follower', () => {
  it('tells its target in time, in the session of the first answer', async () => {
    follower.begin({ pose: 1 });
    await answered(1000);
    expect(kEveryMs / 1000).toBeLessThan(kGoodForS / 2);
    expect(asked.length).toBeGreaterThanOrEqual(19);
    expect(asked[0]!.args).toEqual({ pose: 1, hold: kGoodForS });
    expect(asked[5]!.args).toEqual({ pose: 1, hold: kGoodForS, session: 4 });
  });

  it('says nothing more once it has ended', async () => {
    follower.begin({ pose: 1 });
    await answered(200);
    follower.end();
    const before = asked.length;
    await answered(500);
    expect(asked.length).toBe(before);
    expect(ends).toEqual([undefined]);
  });

  it('sends nothing before it has a target', async () => {
    follower.begin(null);
    await answered(200);
    expect(asked.length).toBe(0);
    follower.set({ pose: 2 });
    await answered(100);
    expect(asked[0]!.args.pose).toBe(2);
  });

  it('ends with what was refused', async () => {
    follower.begin({ pose: 1 });
    asked[0]!.refuse('no');
    await vi.advanceTimersByTimeAsync(10);
    expect(follower.held).toBe(false);
    expect(ends).toEqual(['no']);
  });

  it('does not pile up what is not answered', async () => {
    follower.begin({ pose: 1 });
    asked[0]!.answer({ session: 1 });
    await vi.advanceTimersByTimeAsync(2000);
    expect(asked.length).toBeLessThanOrEqual(4);
  });

  it('begins a session of its own each time, whatever comes late', async () => {
    follower.begin({ pose: 1 });
    follower.end();
    follower.begin({ pose: 2 });
    asked[0]!.answer({ session: 1 });
    await vi.advanceTimersByTimeAsync(3 * kEveryMs);
    const second = asked.filter((each) => each.args.pose === 2);
    expect(second[0]!.args.session).toBeUndefined();
  });
});
