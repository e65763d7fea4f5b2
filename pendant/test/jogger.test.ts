import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { Jogger, type JogMotion, kBeatMs } from '../src/wire/jogger';

let told: [string, unknown][];
let asked: { args: unknown; answer: (jog: number) => void; refuse: (e: unknown) => void }[];
let changes: [boolean, unknown?][];
let heard: boolean;
let jogger: Jogger;
const motion: JogMotion = { request: 'jog.begin', args: { axis: 2 } };

beforeEach(() => {
  vi.useFakeTimers();
  [told, asked, changes, heard] = [[], [], [], true];
  jogger = new Jogger(
    {
      request: (_, args) =>
        new Promise((resolve, reject) => {
          asked.push({ args, answer: (jog) => resolve({ jog }), refuse: reject });
        }),
      tell: (name, args) => (told.push([name, args]), heard),
    },
    (held, error) => changes.push([held, error]),
  );
});
afterEach(() => void vi.useRealTimers());
const beats = () => told.filter(([name]) => name === 'jog.beat').length;

describe('a held key', () => {
  it('beats at least every 50 ms until it is let go', async () => {
    void jogger.begin(motion);
    asked[0]!.answer(5);
    await vi.advanceTimersByTimeAsync(1000);
    expect(kBeatMs).toBeLessThanOrEqual(50);
    expect(beats()).toBeGreaterThanOrEqual(20);
    jogger.end();
    expect(told.at(-1)).toEqual(['jog.end', { jog: 5 }]);
    const before = told.length;
    await vi.advanceTimersByTimeAsync(1000);
    expect(told.length).toBe(before);
  });

  it('that is let go before the answer ends what the answer began', async () => {
    void jogger.begin(motion);
    jogger.end();
    asked[0]!.answer(6);
    await vi.advanceTimersByTimeAsync(500);
    expect(told).toEqual([['jog.end', { jog: 6 }]]);
    expect(jogger.held).toBe(false);
  });

  it('does not go on when the cell ends it: a new press is needed', async () => {
    void jogger.begin(motion);
    asked[0]!.answer(7);
    await vi.advanceTimersByTimeAsync(10);
    jogger.ended(7);
    const before = beats();
    await vi.advanceTimersByTimeAsync(500);
    expect(beats()).toBe(before);
    expect(jogger.held).toBe(false);
    expect(changes.at(-1)?.[0]).toBe(false);
  });

  it('is not ended by the end of another motion', async () => {
    void jogger.begin(motion);
    asked[0]!.answer(8);
    await vi.advanceTimersByTimeAsync(10);
    jogger.ended(7);
    expect(jogger.held).toBe(true);
  });

  it('ends where nobody hears it', async () => {
    void jogger.begin(motion);
    asked[0]!.answer(9);
    await vi.advanceTimersByTimeAsync(10);
    heard = false;
    await vi.advanceTimersByTimeAsync(100);
    expect(jogger.held).toBe(false);
  });

  it('that is refused says why and beats never', async () => {
    void jogger.begin(motion);
    asked[0]!.refuse('no');
    await vi.advanceTimersByTimeAsync(200);
    expect(changes.at(-1)).toEqual([false, 'no']);
    expect(beats()).toBe(0);
  });

  it('that follows another ends that one first', async () => {
    void jogger.begin(motion);
    asked[0]!.answer(1);
    await vi.advanceTimersByTimeAsync(10);
    void jogger.begin(motion);
    expect(told.at(-1)).toEqual(['jog.end', { jog: 1 }]);
    asked[1]!.answer(2);
    await vi.advanceTimersByTimeAsync(100);
    expect(told.at(-1)).toEqual(['jog.beat', { jog: 2 }]);
  });

  it('steers with the next beat, once', async () => {
    void jogger.begin(motion);
    asked[0]!.answer(3);
    await vi.advanceTimersByTimeAsync(10);
    jogger.steer({ axis: [0, 1, 0] });
    await vi.advanceTimersByTimeAsync(2 * kBeatMs);
    expect(told.slice(-2)).toEqual([
      ['jog.beat', { jog: 3, axis: [0, 1, 0] }],
      ['jog.beat', { jog: 3 }],
    ]);
  });
});
