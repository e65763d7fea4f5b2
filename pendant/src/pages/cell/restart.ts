/** Requests that restart the cell. The connection stays open; the cell is unavailable for a moment. */
import type { Args, RequestName } from '../../state/cell';
import { signal } from '@preact/signals';
import { t } from '../../i18n';
import { complain, request } from '../../state/cell';
import { layout } from '../../state/live';
import { loadScene } from '../../state/models';
import { toast } from '../../state/toasts';
import { ask } from '../../ui/ask';

/** What restarts the cell now, in words; '' while nothing does. */
export const restarting = signal('');
const kPatienceMs = 30_000;

/**
 * Sends a request that restarts the cell. Returns true when the new cell is running and `wrong` reports no
 * problem.
 */
export async function restart<Name extends RequestName>(what: string, done: string, name: Name, args: Args<Name>, wrong: () => string = () => ''): Promise<boolean> {
  if (restarting.value) return false;
  restarting.value = what;
  const before = layout.peek().id;
  try {
    await request<RequestName>(name, args, kPatienceMs);
    await newLayout(before);
    const problem = wrong();
    toast(problem ? { kind: 'warning', text: problem } : { kind: 'ok', text: done });
    return problem === '';
  } catch (error) {
    complain(error);
    return false;
  } finally {
    restarting.value = '';
  }
}

/** Waits for the layout of the new cell, which differs from the one before. */
function newLayout(before: number): Promise<void> {
  return new Promise((resolve) => {
    const until = performance.now() + 10_000;
    const timer = setInterval(() => {
      if (layout.peek().id === before && performance.now() < until) return;
      clearInterval(timer);
      resolve();
    }, 50);
  });
}

/** Resets parts, data and program to their initial state, after a question. */
export function askReset(): void {
  const reset = async () => {
    await restart(t('cell.resetting'), t('cell.wasReset'), 'cell.reset', {});
    await loadScene();
  };
  ask({ title: t('cell.resetQ'), text: t('cell.resetText'), action: t('cell.reset'), onYes: () => void reset() });
}
