/** Reads the cell's data about its loop. Nothing here throws. */
import type { Json } from './connection';

/**
 * Times in microseconds. `buckets`: the number of times up to `to` that are longer than the limit of the
 * bucket before.
 */
export interface Times {
  p50: number;
  p99: number;
  max: number;
  buckets: { to: number; count: number }[];
}
export interface Part {
  name: string;
  kind: string;
  rate: number;
  turns: number;
  missed: number;
  cost: Times | null;
}
export interface HealthNow {
  state: string;
  cause: string;
  seconds: number;
  rate: number;
  cycles: number;
  late: number;
  cost: Times | null;
  wakeUp: Times | null;
  period: Times | null;
  clamps: number;
  parts: Part[];
  /** `controllers`: names of those that stopped with it. */
  fallen: {component: string; cause: string; cause_code: string; controllers: string[]}[];
}
/** Accepts all units that the cell may send (…_ns, …_us, or none for us). */
export function readTimes(value: unknown): Times | null {
  if (!value || typeof value !== 'object') return null;
  const got = value as Json;
  const of = (key: string) => (typeof got[`${key}_ns`] === 'number' ? (got[`${key}_ns`] as number) / 1000 : Number(got[`${key}_us`] ?? got[key] ?? NaN));
  const buckets = Array.isArray(got.buckets) ? (got.buckets as Json[]) : [];
  const out: Times = {
    p50: of('p50'),
    p99: of('p99'),
    max: of('max'),
    buckets: buckets.map((each) => ({ to: typeof each.to_ns === 'number' ? each.to_ns / 1000 : Number(each.to_us), count: Number(each.count) })),
  };
  return out.max > 0 ? out : null;
}

export function readHealth(got: Json): HealthNow {
  const list = (value: unknown) => (Array.isArray(value) ? (value as Json[]) : []);
  const part = (each: Json): Part => ({
    name: String(each.component ?? each.controller ?? ''),
    kind: each.component !== undefined ? 'component' : 'controller',
    rate: Number(each.rate_hz ?? 0),
    turns: Number(each.turns ?? each.runs ?? 0),
    missed: Number(each.missed ?? 0),
    cost: readTimes(each.cost),
  });
  return {
    state: String(got.state ?? ''),
    cause: String(got.cause ?? ''),
    seconds: Number(got.time_s ?? 0),
    rate: Number(got.rate_hz ?? 0),
    cycles: Number(got.cycles ?? 0),
    late: Number(got.late ?? 0),
    cost: readTimes(got.cost),
    wakeUp: readTimes(got.wake_up),
    period: readTimes(got.period),
    clamps: Number(got.clamps ?? 0),
    parts: [...list(got.parts), ...list(got.threads)].map(part),
    fallen: list(got.fallen) as unknown as HealthNow['fallen'],
  };
}

/** Merges neighbouring buckets into at most `most` bars, from the first non-empty bucket to the last. */
export function bars(times: Times, most: number): { from: number; to: number; count: number }[] {
  const used = times.buckets.filter((each) => each.count > 0);
  if (used.length === 0) return [];
  const first = times.buckets.indexOf(used[0]!);
  const last = times.buckets.indexOf(used[used.length - 1]!);
  const step = Math.max(1, Math.ceil((last - first + 1) / most));
  const out: { from: number; to: number; count: number }[] = [];
  for (let i = first; i <= last; i += step) {
    const mine = times.buckets.slice(i, Math.min(i + step, last + 1));
    out.push({ from: i > 0 ? times.buckets[i - 1]!.to : 0, to: mine[mine.length - 1]!.to, count: mine.reduce((sum, each) => sum + each.count, 0) });
  }
  return out;
}
