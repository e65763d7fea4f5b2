/** Requests after which the cell begins anew: the connection stays, the cell is away for a moment. */
import type { Args, RequestName } from '../../state/cell';
import { signal } from '@preact/signals';
import { t } from '../../i18n';
import { complain, request } from '../../state/cell';
import { layout } from '../../state/live';
import { loadScene } from '../../state/models';
import { toast } from '../../state/toasts';
import { ask } from '../../ui/ask';

/** What is being done, in words; '' nothing. */
export const restarting = signal('');
const kPatienceMs = 30_000;

/** True when the new cell is there, and `wrong` says of it that nothing is. */
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

/** A cell that begins tells a layout of its own. */
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

/** Puts parts, data and program back to their beginning, after a question. */
export function askReset(): void {
  const reset = async () => {
    await restart(t('cell.resetting'), t('cell.wasReset'), 'cell.reset', {});
    await loadScene();
  };
  ask({ title: t('cell.resetQ'), text: t('cell.resetText'), action: t('cell.reset'), onYes: () => void reset() });
}
