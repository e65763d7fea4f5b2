/**
 * Brings failed hardware back. The reason of the last refusal stays until something comes back: the reason of
 * the fault itself may be over by then, and another one is in the way.
 */
import { effect, signal } from '@preact/signals';
import { type Problem, problemOf } from '../i18n/told';
import type { Answer, Args } from './cell';
import { complain, onEvent, request, status } from './cell';

/** Why the last activation was refused; null: none was, or what was missing is active again. */
export const lastRefusal = signal<Problem | null>(null);
effect(() => {
  if ((status.value?.inactive.length ?? 0) === 0) lastRefusal.value = null;
});
// Another cell, or this one opened again.
onEvent('layout', () => (lastRefusal.value = null));

/** Null if the cell refused; the refusal has been shown. */
export async function recoverHardware(args: Args<'hardware.recover'>): Promise<Answer<'hardware.recover'> | null> {
  try {
    const answer = await request('hardware.recover', args);
    lastRefusal.value = null;
    return answer;
  } catch (error) {
    lastRefusal.value = problemOf(error);
    complain(error);
    return null;
  }
}
