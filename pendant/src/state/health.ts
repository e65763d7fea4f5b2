/** The health of loop, hardware and controllers. Requested once a second while a component uses it. */
import { effect, signal } from '@preact/signals';
import type { Json } from '../wire/connection';
import { type HealthNow, readHealth } from '../wire/health';
import { complain, connected, request } from './cell';

export interface Limit {
  interface: string;
  /** The controller that commands it now; empty: none. */
  claimed_by: string;
  limit: string;
  count: number;
  /** Null: NaN or infinite. */
  asked: number | null;
  given: number | null;
  time_s: number;
}
export interface Component {
  name: string;
  type: string;
  plugin: string;
  state: string;
  being: string;
  rate: number;
  async: boolean;
  missed: number;
  states: string[];
  commands: { name: string; claimed_by: string }[];
}
export interface Controller {
  name: string;
  type: string;
  state: string;
  chained: boolean;
  stale: boolean;
  rate: number;
  missed: number;
  claimed: string[];
}

export const health = signal<HealthNow | null>(null);
export const limits = signal<Limit[]>([]);
export const hardware = signal<Component[]>([]);
export const controllers = signal<Controller[]>([]);

export async function loadHealth(): Promise<void> {
  try {
    const [now, clamped, components, list] = await Promise.all([
      request('health'), request('limits'), request('hardware.list'), request('control.list'),
    ]);
    health.value = readHealth(now as unknown as Json);
    limits.value = clamped;
    hardware.value = components;
    controllers.value = list;
  } catch (error) {
    if (connected.peek()) complain(error);
  }
}

export function followHealth(): () => void {
  const end = effect(() => {
    if (connected.value) return void loadHealth();
    // Old values are not shown.
    health.value = null;
    limits.value = [];
    hardware.value = [];
    controllers.value = [];
  });
  const timer = setInterval(() => {
    if (connected.peek()) void loadHealth();
  }, 1000);
  return () => {
    clearInterval(timer);
    end();
  };
}
