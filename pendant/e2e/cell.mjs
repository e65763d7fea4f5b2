// A running cell to test against, and a second client that reads it over the same wire.
import { spawn } from 'node:child_process';
import { cpSync, mkdirSync, mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import WebSocket from 'ws';

const root = fileURLToPath(new URL('../..', import.meta.url));
export const polyarm = process.env.POLYARM ?? join(root, 'build/release/polyarm');

/** `what` once it holds; asked again and again for at most `seconds`. */
export async function until(what, seconds = 60, name = what.toString()) {
  const end = Date.now() + 1000 * seconds;
  for (;;) {
    const got = await what();
    if (got) return got;
    if (Date.now() > end) throw new Error(`did not come within ${seconds} s: ${name}`);
    await new Promise((done) => setTimeout(done, 15));
  }
}

export class Cell {
  /** A copy of the example; an empty folder where none is named. */
  constructor(example, options = []) {
    this.home = mkdtempSync(join(tmpdir(), 'polyarm-pendant-'));
    this.folder = join(this.home, example ?? 'own');
    mkdirSync(this.folder);
    if (example) cpSync(join(root, 'examples', example), this.folder, { recursive: true, filter: (from) => !from.endsWith('/.state') });
    this.options = options;
    this.port = 0;
    this.output = '';
  }

  async start() {
    this.output = '';
    this.child = spawn(polyarm, ['run', this.folder, '--pendant', '--port', String(this.port), '--no-socket', ...this.options], {
      cwd: root,
      env: { ...process.env, XDG_RUNTIME_DIR: this.home, XDG_DATA_HOME: join(this.home, 'data'), XDG_CONFIG_HOME: join(this.home, 'config') },
    });
    for (const stream of [this.child.stdout, this.child.stderr]) stream.on('data', (text) => (this.output += text));
    this.ended = new Promise((done) => this.child.on('exit', done));
    const link = await until(() => /pendant: (http:\S+)/.exec(this.output)?.[1], 60, 'the link of the pendant').catch((error) => {
      throw new Error(`${error.message}\n${this.output}`);
    });
    this.link = link;
    this.port = Number(new URL(link).port);
    this.token = new URL(link).searchParams.get('token');
    return link;
  }

  /** As a power cut would. */
  async kill() {
    this.child.kill('SIGKILL');
    await this.ended;
  }

  async end() {
    if (this.child?.exitCode === null) {
      this.child.kill('SIGINT');
      const late = setTimeout(() => this.child.kill('SIGKILL'), 5000);
      await this.ended;
      clearTimeout(late);
    }
    rmSync(this.home, { recursive: true, force: true });
  }
}

/** A program that looks on: newest frame by names, every frame with its time, requests. */
export class Watcher {
  constructor(cell) {
    this.cell = cell;
    this.frames = [];
    this.events = {};
    this.holds = [];
    this.open = new Map();
    this.next = 1;
  }

  async start(name = 'test') {
    this.socket = new WebSocket(`ws://127.0.0.1:${this.cell.port}/ws?token=${this.cell.token}`);
    this.socket.binaryType = 'nodebuffer';
    this.socket.on('message', (data, binary) => (binary ? this.frame(data) : this.text(JSON.parse(data))));
    await new Promise((done, failed) => this.socket.on('open', done).on('error', failed));
    this.hello = await this.request('session.hello', { name });
    await this.request('session.watch', { rate: 60 });
    await until(() => this.frames.length > 0, 60, 'the first frame');
    return this;
  }

  request(request, args = {}) {
    const id = this.next++;
    this.socket.send(JSON.stringify({ id, request, ...args }));
    return new Promise((done, failed) => this.open.set(id, { done, failed }));
  }

  text(message) {
    if (message.event) {
      this.events[message.event] = message;
      if (message.event === 'status') this.note(message);
      if (message.event === 'layout') this.places = new Map(message.fields.map((field, i) => [field.name, i]));
      return;
    }
    const open = this.open.get(message.id);
    if (!open || message.more) return;
    this.open.delete(message.id);
    message.ok ? open.done(message.result) : open.failed(Object.assign(new Error(message.error?.what), message.error));
  }

  /** Stops that nobody asked for and no case brings about: the machine stood still, or was late. */
  note({ state, cause_code }) {
    if (state === this.last || !['gap', 'cell-silent', 'late'].includes(cause_code)) return void (this.last = state);
    this.last = state;
    if (state !== 'running') this.holds.push(`${state}: ${cause_code}`);
  }

  frame(data) {
    this.frames.push({ time: data.readDoubleLE(8), data });
    if (this.frames.length > 3000) this.frames.shift();
  }

  get time() {
    return this.frames.at(-1).time;
  }
  value(field, frame = this.frames.at(-1)) {
    return frame.data.readFloatLE(16 + 4 * this.places.get(field));
  }
  /** The fastest joint of a frame, rad/s. */
  speed(frame = this.frames.at(-1)) {
    let out = 0;
    for (const [name, place] of this.places)
      if (name.endsWith('_joint/velocity')) out = Math.max(out, Math.abs(frame.data.readFloatLE(16 + 4 * place)));
    return out;
  }
  end() {
    this.socket?.terminate();
  }
}
