import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { Connection, type LinkState, RequestError, type Socket } from '../src/wire/connection';

class FakeSocket implements Socket {
  binaryType = '';
  readyState = 0;
  bufferedAmount = 0;
  onopen: unknown = null;
  onclose: unknown = null;
  onerror: unknown = null;
  onmessage: unknown = null;
  sent: Record<string, unknown>[] = [];
  send(text: string) {
    this.sent.push(JSON.parse(text));
  }
  close() {
    this.drop(1000);
  }
  accept() {
    this.readyState = 1;
    (this.onopen as () => void)();
  }
  drop(code = 1006) {
    this.readyState = 3;
    (this.onclose as (e: { code: number }) => void)({ code });
  }
  say(data: unknown) {
    (this.onmessage as (e: { data: unknown }) => void)({ data: data instanceof ArrayBuffer ? data : JSON.stringify(data) });
  }
}

let sockets: FakeSocket[];
let states: LinkState[];
let events: unknown[];
let frames: ArrayBuffer[];
let connection: Connection;
const last = () => sockets[sockets.length - 1]!;

beforeEach(() => {
  vi.useFakeTimers();
  sockets = [];
  states = [];
  events = [];
  frames = [];
  connection = new Connection({
    open: () => {
      sockets.push(new FakeSocket());
      return last();
    },
    onEvent: (event) => events.push(event),
    onFrame: (frame) => frames.push(frame),
    onState: (state) => states.push(state),
    firstWait: 100,
    longestWait: 400,
    openWithin: 1000,
  });
});
afterEach(() => {
  connection.end();
  vi.useRealTimers();
});

function connect() {
  connection.start();
  last().accept();
}

describe('requests', () => {
  it('are answered by id, in any order', async () => {
    connect();
    const first = connection.request('a', { x: 1 });
    const second = connection.request('b');
    expect(last().sent).toEqual([
      { id: 1, request: 'a', x: 1 },
      { id: 2, request: 'b' },
    ]);
    last().say({ id: 2, ok: true, result: 'two' });
    last().say({ id: 1, ok: true, result: 'one' });
    expect(await Promise.all([first, second])).toEqual(['one', 'two']);
  });

  it('are refused with the code and the words of the cell', async () => {
    connect();
    const asked = connection.request('jog.begin');
    last().say({ id: 1, ok: false, error: { code: 'no-control', what: 'another client has control', advice: 'take it' } });
    const error = (await asked.catch((e) => e)) as RequestError;
    expect(error).toBeInstanceOf(RequestError);
    expect([error.code, error.message, error.problem.advice]).toEqual(['no-control', 'another client has control', 'take it']);
  });

  it('fail in time where no answer comes, and a late answer is nobody’s', async () => {
    connect();
    const asked = connection.request('health', {}, 500).catch((e) => e.code);
    vi.advanceTimersByTime(501);
    expect(await asked).toBe('no-answer');
    last().say({ id: 1, ok: true, result: 1 });
  });

  it('fail at once where there is no connection, or when it is lost', async () => {
    connection.start();
    expect(await connection.request('a').catch((e) => e.code)).toBe('not-connected');
    last().accept();
    const open = connection.request('b').catch((e) => e.code);
    last().drop();
    expect(await open).toBe('not-connected');
  });

  it('stream until they are stopped', async () => {
    connect();
    const got: unknown[] = [];
    const stream = connection.stream('program.watch', {}, (each) => got.push(each));
    last().say({ id: 1, ok: true, more: true, result: 1 });
    last().say({ id: 1, ok: true, more: true, result: 2 });
    stream.stop();
    last().say({ id: 1, ok: true, more: true, result: 3 });
    expect(got).toEqual([1, 2]);
    expect(last().sent[1]).toEqual({ request: 'session.end', of: 1 });
  });

  it('end a stream with its last answer', async () => {
    connect();
    const stream = connection.stream('jog', {}, () => undefined);
    last().say({ id: 1, ok: true, more: true, result: 1 });
    last().say({ id: 1, ok: true, result: 'done' });
    expect(await stream.done).toBe('done');
  });
});

describe('what comes', () => {
  it('goes to where it belongs; nonsense is ignored', () => {
    connect();
    const frame = new ArrayBuffer(16);
    last().say(frame);
    last().say({ event: 'status', state: 'held' });
    (last().onmessage as (e: { data: unknown }) => void)({ data: '{broken' });
    last().say({ id: 99, ok: true });
    expect(frames).toEqual([frame]);
    expect(events).toEqual([{ event: 'status', state: 'held' }]);
  });
});

describe('a lost connection', () => {
  it('is tried again, later and later, and soon again once it was open', () => {
    connection.start();
    const tries: number[] = [];
    for (let i = 0; i < 4; ++i) {
      last().drop();
      const before = sockets.length;
      let waited = 0;
      while (sockets.length === before) {
        vi.advanceTimersByTime(50);
        waited += 50;
      }
      tries.push(waited);
    }
    expect(tries).toEqual([100, 200, 400, 400]);
    last().accept();
    last().drop();
    vi.advanceTimersByTime(100);
    expect(sockets.length).toBe(6);
  });

  it('is tried at once when it is hurried, and only once', () => {
    connect();
    last().drop();
    connection.hurry();
    expect(sockets.length).toBe(2);
    vi.advanceTimersByTime(100);
    expect(sockets.length).toBe(2);
  });

  it('is given up where it does not open', () => {
    connection.start();
    vi.advanceTimersByTime(1001);
    expect(states).toContain('lost');
  });

  it('is told as refused where the server says so', () => {
    connect();
    last().drop(4401);
    expect(states[states.length - 1]).toBe('refused');
  });

  it('stays lost after end', () => {
    connect();
    connection.end();
    vi.advanceTimersByTime(10_000);
    expect(sockets.length).toBe(1);
  });

  it('hears nothing more from the socket before', () => {
    connect();
    const old = last();
    old.drop();
    connection.hurry();
    last().accept();
    old.drop();
    expect(states[states.length - 1]).toBe('open');
  });
});

describe('telling', () => {
  it('says whether anybody can hear it', () => {
    connection.start();
    expect(connection.tell('jog.beat', { jog: 1 })).toBe(false);
    last().accept();
    expect(connection.tell('jog.beat', { jog: 1 })).toBe(true);
    expect(last().sent).toEqual([{ request: 'jog.beat', jog: 1 }]);
  });
});

describe('a cell that falls silent without closing its socket', () => {
  const frame = () => last().say(new ArrayBuffer(4));
  function watch() {
    connect();
    for (let i = 0; i < 30; ++i) {
      vi.advanceTimersByTime(33);
      frame();
    }
  }

  it('is lost after about 1.5 s without a frame', () => {
    watch();
    vi.advanceTimersByTime(1_400);
    expect(states.at(-1)).toBe('open');
    vi.advanceTimersByTime(700);
    expect(states.at(-1)).toBe('lost');
  });

  it('gets no request but a stop', async () => {
    watch();
    vi.advanceTimersByTime(3_000);
    const before = last().sent.length;
    await expect(connection.request('resume')).rejects.toThrow(RequestError);
    expect(connection.tell('jog')).toBe(false);
    expect(last().sent.length).toBe(before);
    expect(connection.tell('control.stop')).toBe(true);
  });

  it('is connected anew with its next frame', () => {
    watch();
    vi.advanceTimersByTime(3_000);
    frame();
    expect(sockets.length).toBe(2);
    last().accept();
    expect(states.at(-1)).toBe('open');
    expect(last().sent.every((each) => each.request !== 'resume')).toBe(true);
  });

  it('is judged after the timer of this page has run twice', () => {
    watch();
    const now = performance.now();
    vi.setSystemTime(Date.now());
    const clock = vi.spyOn(performance, 'now').mockReturnValue(now + 60_000); // the page was busy or hidden
    vi.advanceTimersByTime(200);
    expect(states.at(-1)).toBe('open');
    frame();
    vi.advanceTimersByTime(1_000);
    expect(states.at(-1)).toBe('open');
    clock.mockRestore();
  });

  it('is not lost while it has sent no frames', () => {
    connect();
    vi.advanceTimersByTime(60_000);
    expect(states).toEqual(['connecting', 'open']);
  });
});
