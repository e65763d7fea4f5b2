// A control loop that stands still is said: its cell still answers, and shows what was true before.
import { beforeEach, expect, it, vi } from 'vitest';
import type { LogLine, Status } from '../src/wire/types';

vi.stubGlobal('navigator', { language: 'en', userAgent: '' });
vi.useFakeTimers();
const { log, status } = await import('../src/state/cell');
const { takeFrame, takeLayout } = await import('../src/state/live');
const { Layout } = await import('../src/wire/frames');
const { loopStands, waitsFor } = await import('../src/state/standing');

let sequence = 0;
/** Frames for so long, of a cell whose time goes on or not. */
let time = 0;
function frames(ms: number, goesOn: boolean): void {
  for (let i = 0; i < ms / 50; ++i) {
    if (goesOn) time += 0.05;
    takeFrame({ layout: 1, sequence: ++sequence, time, values: new Float32Array() });
    vi.advanceTimersByTime(50);
  }
}

beforeEach(() => {
  takeLayout(new Layout(1, []));
  status.value = null;
  status.value = { state: 'running', inactive: [] } as unknown as Status;
  log.value = [];
});

it('is seen while frames still come, and over as soon as the time goes on', () => {
  frames(5000, true);
  expect(loopStands.value).toBe(false);
  frames(4000, false);
  expect(loopStands.value).toBe(true);
  frames(100, true);
  expect(loopStands.value).toBe(false);
});

it('is seen, too, if no frame comes', () => {
  frames(1000, true);
  vi.advanceTimersByTime(4000);
  expect(loopStands.value).toBe(true);
});

it('is not said of a cell that has not begun, nor of none', () => {
  frames(5000, false);
  expect(loopStands.value).toBe(false);
  frames(1000, true);
  frames(4000, false);
  status.value = { state: 'no cell', inactive: [] } as unknown as Status;
  expect(loopStands.value).toBe(false);
});

it('names what the loop waits for', () => {
  const line = (text: string) => (log.value = [...log.value, { number: 1, time: 1, level: 'note', text } as LogLine]);
  expect(waitsFor()).toBe('');
  line('the control loop does not run: it waits for the hardware component arm; give it is_async="true"');
  expect(waitsFor()).toBe('arm');
  line('the control loop does not run: it waits for the controller my follower; give it is_async: true');
  expect(waitsFor()).toBe('my follower');
  line('the control loop does not run');
  expect(waitsFor()).toBe('');
});
