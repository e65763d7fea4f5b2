/**
 * The newest state frame. Pictures read it in every animation frame; numbers on pages follow `beat`, ten
 * times a second.
 */
import { signal } from '@preact/signals';
import { type Frame, isLater, Layout } from '../wire/frames';

export const layout = signal(new Layout(-1, []));
/** Increases at about 10 Hz while frames arrive. Components that read it render again. */
export const beat = signal(0);
/** Cell time of the newest frame, s. */
export const cellTime = signal(0);

const kBeatMs = 100;
let newest: Frame | null = null;
let told = 0;
type Listener = (frame: Frame) => void;
const listeners = new Set<Listener>();

export function takeLayout(next: Layout): void {
  layout.value = next;
  newest = null;
}

export function takeFrame(frame: Frame): void {
  if (frame.layout !== layout.peek().id) return;
  if (newest && !isLater(frame.sequence, newest.sequence)) return;
  newest = frame;
  for (const listener of listeners) listener(frame);
  const now = performance.now();
  if (now - told < kBeatMs) return;
  told = now;
  cellTime.value = frame.time;
  beat.value++;
}

export function newestFrame(): Frame | null {
  return newest;
}

/** Calls the listener with every frame, for plots and trails. Returns a function that ends it. */
export function onFrame(listener: Listener): () => void {
  listeners.add(listener);
  return () => listeners.delete(listener);
}

/** The newest value of a field; NaN if it does not exist. A component that calls it follows `beat`. */
export function valueOf(name: string): number {
  beat.value;
  return valueNow(name);
}

/** The same without rendering again. */
export function valueNow(name: string): number {
  const place = layout.peek().place(name);
  return place >= 0 && newest ? (newest.values[place] ?? NaN) : NaN;
}

/** A new connection restarts the numbering of frames. */
export function forgetFrames(): void {
  newest = null;
  beat.value++;
}
