/** Activates inactive hardware, then the controllers that failed with it. */
import { t } from '../i18n';
import { complain, mayMove, request, status, ways } from '../state/cell';
import { recoverHardware } from '../state/recovery';
import { ask } from '../ui/ask';

export function activateAll(): void {
  const names = status.peek()?.inactive ?? [];
  ask({
    title: t('state.activateQ', { names: names.join(', ') }),
    text: t('state.activateText'),
    action: t('state.activate'),
    onYes: () => void activate().catch(complain),
    still: () => mayMove.value && ways.value.next === 'activate',
  });
}

async function activate(): Promise<void> {
  const names = status.peek()?.inactive ?? [];
  const back = await recoverHardware({ controllers: true });
  if (!back || back.started?.length) return;
  // The cell did not begin with what is inactive, for example a controller that was loaded later.
  const devices = await request('hardware.list');
  const controllers = names.filter((name) => !devices.some((each) => each.name === name));
  if (controllers.length) await request('control.switch', { activate: controllers, deactivate: [] });
}
