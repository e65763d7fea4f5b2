import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { type Draft, DraftKeeper, type DraftState, type DraftStore } from '../src/pages/program/drafts';

let sent: Draft[];
let states: DraftState[];
let kept: Map<string, Draft>;
let works: boolean;
let may: boolean;
let refuses: boolean;
let asked: number;
let keeper: DraftKeeper;
const draft = (text: string, name = 'a.script'): Draft => ({ name, text, base: 'h' });

beforeEach(() => {
  vi.useFakeTimers();
  sent = [];
  states = [];
  kept = new Map();
  works = may = true;
  refuses = false;
  asked = 0;
  const store: DraftStore = {
    get: (name) => kept.get(name) ?? null,
    set: (each) => void kept.set(each.name, each),
    remove: (name) => void kept.delete(name),
  };
  keeper = new DraftKeeper({
    send: async (each) => {
      ++asked;
      if (refuses) throw new Error('refused');
      if (!works) throw new Error('gone');
      sent.push(each);
    },
    may: () => may,
    isRefusal: (error) => (error as Error).message === 'refused',
    onState: (state) => states.push(state),
    store,
  });
});
afterEach(() => vi.useRealTimers());

describe('DraftKeeper', () => {
  it('sends the newest text soon after the last change', async () => {
    keeper.note(draft('1'));
    keeper.note(draft('12'));
    await vi.advanceTimersByTimeAsync(310);
    expect(sent.map((each) => each.text)).toEqual(['12']);
    expect(states[states.length - 1]).toBe('kept');
    expect(kept.size).toBe(0);
  });
  it('does not wait for a pause of who writes on and on', async () => {
    for (let i = 0; i < 20; ++i) {
      keeper.note(draft(String(i)));
      await vi.advanceTimersByTimeAsync(100);
    }
    expect(sent.length).toBeGreaterThanOrEqual(2);
  });
  it('keeps it in the browser and tries again where the server is gone', async () => {
    works = false;
    keeper.note(draft('x'));
    await vi.advanceTimersByTimeAsync(400);
    expect(states[states.length - 1]).toBe('waiting');
    expect(kept.get('a.script')?.text).toBe('x');
    works = true;
    await vi.advanceTimersByTimeAsync(1100);
    expect(sent.map((each) => each.text)).toEqual(['x']);
    expect(kept.size).toBe(0);
  });
  it('keeps what a page may not send in the browser, without asking, until the page may', async () => {
    may = false;
    for (let i = 0; i < 10; ++i) {
      keeper.note(draft(String(i)));
      await vi.advanceTimersByTimeAsync(1000);
    }
    expect(asked).toBe(0);
    expect(states[states.length - 1]).toBe('here');
    expect(kept.get('a.script')?.text).toBe('9');
    may = true;
    keeper.retry();
    await vi.advanceTimersByTimeAsync(0);
    expect(sent.map((each) => each.text)).toEqual(['9']);
    expect(kept.size).toBe(0);
  });
  it('does not repeat a draft that the server refuses, and sends the next one', async () => {
    refuses = true;
    keeper.note(draft('x'));
    await vi.advanceTimersByTimeAsync(10_000);
    expect([asked, states[states.length - 1], kept.get('a.script')?.text]).toEqual([1, 'here', 'x']);
    refuses = false;
    keeper.note(draft('xy'));
    await vi.advanceTimersByTimeAsync(400);
    expect(sent.map((each) => each.text)).toEqual(['xy']);
  });
  it('has nothing to send again once it is kept', async () => {
    keeper.note(draft('x'));
    await vi.advanceTimersByTimeAsync(400);
    keeper.retry();
    await vi.advanceTimersByTimeAsync(400);
    expect(asked).toBe(1);
  });
  it('sends one file’s before another’s is noted', async () => {
    keeper.note(draft('x'));
    keeper.note(draft('y', 'b.script'));
    await vi.advanceTimersByTimeAsync(400);
    expect(sent.map((each) => each.name)).toEqual(['a.script', 'b.script']);
  });
  it('sends nothing more once it is forgotten', async () => {
    keeper.note(draft('x'));
    keeper.forget('a.script');
    await vi.advanceTimersByTimeAsync(5000);
    expect(sent).toEqual([]);
    expect(kept.size).toBe(0);
  });
  it('sends at once when asked to', async () => {
    keeper.note(draft('x'));
    keeper.flush();
    await vi.advanceTimersByTimeAsync(0);
    expect(sent.length).toBe(1);
  });
});
