/** Actions on the cell as a whole. */
import {t} from '../i18n';
import type { RequestError } from '../wire/connection';

import {attempt, complain, pausing, programRuns, request, status, ways} from './cell';
import {dropSteps} from './jog';
import {toast} from './toasts';
import {canBe} from './ways';

/** Stops all motion. Needs no control, and is sent even if the cell seems silent. */
export async function stop(): Promise<void> {
  dropSteps();
  try {
    await request('control.stop', {}, 2_000);
  } catch (error) {
    if ((error as RequestError).code === 'no-cell') return toast({ kind: 'info', text: t('stop.noCell') });
    toast({ kind: 'error', text: t('stop.failed'), detail: t('stop.useRealOne') });
  }
}
export const hold = () => (dropSteps(), attempt('control.hold'));
export const resume = () => attempt('control.resume');
export const recover = () => attempt('control.recover');
export async function discard(): Promise<void> {
  const motion = ways.peek().discards === 'motion';
  if ((await attempt('control.discard')) && motion) toast({ kind: 'info', text: t('told.discarded') });
}
/** Continues: a held motion along its path, else the program that a step or a breakpoint has paused. */
export const goOn = () => (status.peek()?.state === 'held' ? resume() : attempt('program.go'));
export const back = () => attempt('control.back', {time: 0.5});
/** The action of the key for pause and resume. Does nothing if neither is possible. */
export function pauseOrGoOn(): void {
  const {next, nextBlocked} = ways.peek();
  if (!canBe(nextBlocked)) return;
  if (next === 'resume')
    void goOn();
  else if (next !== 'recover')
    void hold();
}

/**
 * Executes one statement. A running program finishes its present statement and pauses; so does a held one
 * after it resumes.
 */
export async function step(how: 'over' | 'into' | 'out' = 'over'): Promise<void> {
  const now = status.peek();
  if (!now?.program || !canBe(ways.peek().step)) return;
  const paused = now.program.paused;
  if (!paused || now.state === 'held') pausing.value = true;
  try {
    // The answer comes when the program has paused. No timeout.
    const done = paused ? request('program.step', { how }, 0) : request('program.pause', {}, 0);
    if (now.state === 'held') await resume();
    await done;
  } catch (error) {
    complain(error);
  } finally {
    pausing.value = false;
  }
}
export const setOverride = (percent: number) => attempt('control.override', { percent });
export const setProfile = (name: string) => attempt('profile', { name });

/** True if a stop would change anything. Escape then stops, even if it would otherwise close a dialog. */
export function somethingGoesOn(): boolean {
  const now = status.peek();
  if (!now) return false;
  return now.moving || now.state === 'backing' || now.state === 'stopping' || (now.state === 'running' && programRuns.peek());
}
