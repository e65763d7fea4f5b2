/**
 * One WebSocket to the cell: requests by id, streams, events, binary frames. Reconnects automatically. A cell
 * that has sent frames and becomes silent counts as lost too, although its socket stays open. Knows nothing
 * of pages or of the meaning of requests.
 */

export interface Problem {
  code: string;
  what: string;
  advice?: string;
  where?: string;
  /** Values of the sentence, by name. */
  facts?: Record<string, string|number>;
  all?: Problem[];
}

/** A request that was refused or not answered. */
export class RequestError extends Error {
  constructor(
    readonly request: string,
    readonly problem: Problem,
  ) {
    super(problem.what);
    this.name = 'RequestError';
  }
  get code(): string {
    return this.problem.code;
  }
}

export type Json = Record<string, unknown>;
export type LinkState = 'connecting' | 'open' | 'lost' | 'refused';

/** The used part of a WebSocket; tests pass their own. */
export interface Socket {
  binaryType: string;
  readyState: number;
  bufferedAmount: number;
  onopen: unknown;
  onclose: unknown;
  onerror: unknown;
  onmessage: unknown;
  send(text: string): void;
  close(): void;
}

export interface ConnectionOptions {
  open: () => Socket;
  onEvent: (event: Json & { event: string }) => void;
  onFrame: (buffer: ArrayBuffer) => void;
  onState: (state: LinkState) => void;
  /** ms until the first attempt to reconnect; doubled after each attempt up to `longestWait`. */
  firstWait?: number;
  longestWait?: number;
  /** ms after which an attempt to connect is given up. */
  openWithin?: number;
  /** ms without any message after which a cell that has sent frames counts as lost. */
  silence?: number;
  /** True while the cell has nothing to send. */
  mayBeSilent?: () => boolean;
}

interface Open {
  request: string;
  resolve: (result: unknown) => void;
  reject: (error: RequestError) => void;
  more?: (result: unknown) => void;
  timer?: ReturnType<typeof setTimeout>;
}

const kOpen = 1;
/**
 * Interval between two checks for silence, ms. Between two checks a busy page still takes its pending
 * messages.
 */
const kLookEvery = 200;
const kSilentLooks = 2;
/**
 * Requests that are sent even to a silent cell, because they stop a motion. No other request may act late.
 */
const kAlsoWhenSilent = new Set(['control.stop']);
/** Close codes by which the server refuses this page. Reconnecting would not help. */
const kRefused = [4401, 4403, 1008];

export class Connection {
  private socket: Socket | null = null;
  private next = 1;
  private readonly open = new Map<number, Open>();
  private wait: number;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private ended = false;
  private looking: ReturnType<typeof setInterval> | undefined;
  private receivedAt = 0;
  private watched = false;
  private silentLooks = 0;
  private silent = false;

  constructor(private readonly options: ConnectionOptions) {
    this.wait = options.firstWait ?? 250;
  }

  start(): void {
    this.ended = false;
    this.connect();
  }

  end(): void {
    this.ended = true;
    clearTimeout(this.timer);
    clearInterval(this.looking);
    this.socket?.close();
  }

  /** Reconnects immediately instead of waiting. */
  hurry(): void {
    if (this.ended || this.socket) return;
    clearTimeout(this.timer);
    this.connect();
  }

  get isOpen(): boolean {
    return this.socket?.readyState === kOpen && !this.silent;
  }

  private canSend(request: string): boolean {
    return this.isOpen || (this.socket?.readyState === kOpen && kAlsoWhenSilent.has(request));
  }

  /** Sends a request and resolves with the result. `timeout` in ms; 0: none. */
  request<T = unknown>(request: string, args: Json = {}, timeout = 10_000): Promise<T> {
    return new Promise<T>((resolve, reject) => {
      this.ask({ request, resolve: resolve as (r: unknown) => void, reject }, args, timeout);
    });
  }

  /**
   * A request with several answers. `each` gets every answer; the promise resolves with the last one. `stop`
   * ends the stream on the server.
   */
  stream<T = unknown>(request: string, args: Json, each: (result: T) => void): { done: Promise<T>; stop: () => void } {
    let id = 0;
    const done = new Promise<T>((resolve, reject) => {
      const open: Open = {
        request,
        resolve: resolve as (r: unknown) => void,
        reject,
        more: each as (r: unknown) => void,
      };
      id = this.ask(open, args, 0);
    });
    done.catch(() => undefined);
    return {
      done,
      stop: () => {
        if (this.open.delete(id)) this.tell('session.end', { of: id });
      },
    };
  }

  /** Sends a message that has no answer. Returns false if there is no connection. */
  tell(request: string, args: Json = {}): boolean {
    if (!this.canSend(request)) return false;
    this.socket!.send(JSON.stringify({ request, ...args }));
    return true;
  }

  private ask(open: Open, args: Json, timeout: number): number {
    const id = this.next++;
    if (!this.canSend(open.request)) {
      open.reject(lost(open.request));
      return id;
    }
    if (timeout > 0) open.timer = setTimeout(() => this.giveUp(id), timeout);
    this.open.set(id, open);
    this.socket!.send(JSON.stringify({ id, request: open.request, ...args }));
    return id;
  }

  private giveUp(id: number): void {
    const open = this.open.get(id);
    if (!open) return;
    this.open.delete(id);
    open.reject(new RequestError(open.request, { code: 'no-answer', what: 'the cell did not answer in time' }));
  }

  private connect(): void {
    this.options.onState('connecting');
    const socket = this.options.open();
    this.socket = socket;
    socket.binaryType = 'arraybuffer';
    const late = setTimeout(() => socket.close(), this.options.openWithin ?? 5_000);
    socket.onopen = () => {
      clearTimeout(late);
      this.wait = this.options.firstWait ?? 250;
      this.hear();
      clearInterval(this.looking);
      this.looking = setInterval(() => this.look(), kLookEvery);
      this.options.onState('open');
    };
    socket.onmessage = (message: { data: unknown }) => {
      if (this.socket !== socket) return;
      if (this.silent) return this.begin();
      this.hear();
      this.take(message.data);
    };
    socket.onerror = () => undefined;
    socket.onclose = (event: { code: number }) => {
      clearTimeout(late);
      if (this.socket === socket) this.lose(event.code);
    };
  }

  private hear(): void {
    this.receivedAt = performance.now();
    this.silentLooks = 0;
  }

  /**
   * Checks for silence. It takes two checks, because the timer of a hidden page runs rarely, and that of a
   * busy page late.
   */
  private look(): void {
    const late = this.watched && performance.now() - this.receivedAt >= (this.options.silence ?? 1_500);
    this.silentLooks = late && this.options.mayBeSilent?.() !== true ? this.silentLooks + 1 : 0;
    if (this.silentLooks < kSilentLooks || this.silent) return;
    this.silent = true;
    this.options.onState('lost');
  }

  /** The silent cell sends again. Opens a new connection, which requests everything that was missed. */
  private begin(): void {
    const old = this.socket;
    this.forget();
    old?.close();
    this.connect();
  }

  private forget(): void {
    clearInterval(this.looking);
    this.silent = this.watched = false;
    this.silentLooks = 0;
    this.socket = null;
    const open = [...this.open.values()];
    this.open.clear();
    for (const each of open) {
      clearTimeout(each.timer);
      each.reject(lost(each.request));
    }
  }

  private lose(code: number): void {
    this.forget();
    this.options.onState(kRefused.includes(code) ? 'refused' : 'lost');
    if (this.ended) return;
    this.timer = setTimeout(() => this.connect(), this.wait);
    this.wait = Math.min(2 * this.wait, this.options.longestWait ?? 4_000);
  }

  private take(data: unknown): void {
    if (data instanceof ArrayBuffer) {
      this.watched = true;
      return this.options.onFrame(data);
    }
    if (typeof data !== 'string') return;
    let message: Json;
    try {
      message = JSON.parse(data) as Json;
    } catch {
      return;
    }
    if (typeof message.event === 'string') return this.options.onEvent(message as Json & { event: string });
    if (typeof message.id === 'number') this.answer(message.id, message);
  }

  private answer(id: number, message: Json): void {
    const open = this.open.get(id);
    if (!open) return;
    if (message.ok === true && message.more === true) return open.more?.(message.result);
    this.open.delete(id);
    clearTimeout(open.timer);
    if (message.ok === true) return open.resolve(message.result);
    const problem = (message.error ?? { code: 'unknown', what: 'refused' }) as Problem;
    open.reject(new RequestError(open.request, problem));
  }
}

function lost(request: string): RequestError {
  return new RequestError(request, { code: 'not-connected', what: 'there is no connection to the cell' });
}
