// Control goes back to the page that had it, also if the cell notices late that its old connection is gone.
import { afterAll, beforeEach, expect, it, vi } from 'vitest';

type Message = Record<string, unknown>;
let holder: { client: number; name: string } | null;
let sockets: FakeSocket[];

/** A cell that gives every connection a number, and does as it is asked. */
class FakeSocket {
  binaryType = '';
  readyState = 1;
  onopen: () => void = () => undefined;
  onclose: (event: { code: number }) => void = () => undefined;
  onmessage: (event: { data: string }) => void = () => undefined;
  readonly client = sockets.push(this);
  constructor() {
    queueMicrotask(() => this.onopen());
  }
  send(text: string) {
    const { id, request } = JSON.parse(text) as { id: number; request: string };
    if (request === 'session.take' && !holder) holder = { client: this.client, name: 'page' };
    const yours = holder?.client === this.client;
    const result = request === 'session.hello' ? { client: this.client, holder, you_hold: yours, role: 'operate' } : request === 'session.take' ? { you_hold: yours } : {};
    queueMicrotask(() => this.say({ id, ok: true, result }));
  }
  say(message: Message) {
    this.onmessage({ data: JSON.stringify(message) });
  }
  /** What the cell says of itself several times a second. */
  status() {
    this.say({ event: 'status', state: 'running', holder, standing: true, alarms: 0 });
  }
  close() {
    this.readyState = 3;
    this.onclose({ code: 1006 });
  }
}
const last = () => sockets.at(-1)!;
const settle = () => vi.advanceTimersByTimeAsync(400);

vi.stubGlobal('navigator', { language: 'en', userAgent: '' });
vi.stubGlobal('location', { protocol: 'http:', host: 'cell' });
vi.stubGlobal('document', { addEventListener: () => undefined });
vi.stubGlobal('addEventListener', () => undefined);
vi.stubGlobal('WebSocket', FakeSocket);
vi.stubGlobal('localStorage', { getItem: () => null, setItem: () => undefined });
[holder, sockets] = [null, []];
const page = await import('../src/state/cell');

beforeEach(async () => {
  vi.useFakeTimers();
  if (sockets.length === 0) page.connect();
  await settle();
  holder = null;
  await page.takeControl(false);
  last().status();
  await settle();
  expect(page.youHold.value).toBe(true);
  // The connection breaks for the page only: the cell still counts it as the one that has control.
  const before = sockets.length;
  last().close();
  await settle();
  last().status();
  expect([sockets.length, page.youHold.value]).toEqual([before + 1, false]);
});
afterAll(() => void vi.useRealTimers());

it('takes control again once the cell has dropped the old connection', async () => {
  holder = null;
  last().status();
  await settle();
  expect([page.youHold.value, holder]).toEqual([true, { client: last().client, name: 'page' }]);
});

it('goes on watching if somebody else has taken control meanwhile', async () => {
  holder = { client: 9, name: 'tablet' };
  last().say({ event: 'control', what: 'taken', name: 'tablet', you_hold: false });
  holder = null;
  last().status();
  await settle();
  expect([page.youHold.value, holder]).toEqual([false, null]);
});

it('does not take control much later', async () => {
  await vi.advanceTimersByTimeAsync(40_000);
  holder = null;
  last().status();
  await settle();
  expect([page.youHold.value, holder]).toEqual([false, null]);
});

const reconnect = async () => {
  last().close();
  await settle();
  last().status();
  await settle();
};

it('does not take what somebody else had at the greeting and releases later', async () => {
  holder = { client: 9, name: 'tablet' };
  await reconnect();
  holder = null;
  last().status();
  await settle();
  expect([page.youHold.value, holder]).toEqual([false, null]);
});

it('does not take what somebody else has had since, although no event said so', async () => {
  for (const now of [{ client: 9, name: 'tablet' }, null]) {
    holder = now;
    last().status();
    await settle();
  }
  expect([page.youHold.value, holder]).toEqual([false, null]);
});

it('takes control again after a second loss, too', async () => {
  await reconnect();
  expect(page.youHold.value).toBe(false);
  holder = null;
  last().status();
  await settle();
  expect([page.youHold.value, holder]).toEqual([true, { client: last().client, name: 'page' }]);
});
