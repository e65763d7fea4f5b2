/** What a person does to the cell as a whole. */
import { toast } from './toasts';
import { t } from '../i18n';
import { attempt, programRuns, request, status } from './cell';

/** Stops whatever moves. Needs no control; tried by every way there is. */
export async function stop(): Promise<void> {
  try {
    await request('control.stop', {}, 2_000);
  } catch {
    toast({ kind: 'error', text: t('stop.failed'), detail: t('stop.useRealOne') });
  }
}
export const hold = () => attempt('control.hold');
export const resume = () => attempt('control.resume');
export const recover = () => attempt('control.recover');
export const discard = () => attempt('control.discard');
export const setOverride = (percent: number) => attempt('control.override', { percent });
export const setProfile = (name: string) => attempt('profile', { name });

/** Would a stop change anything? Then the key stops even where it would else close a dialog. */
export function somethingGoesOn(): boolean {
  const now = status.peek();
  if (!now) return false;
  return now.moving || now.state === 'backing' || now.state === 'stopping' || (now.state === 'running' && programRuns.peek());
}
