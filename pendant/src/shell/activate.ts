/** Activates inactive hardware, then the controllers that failed with it. */
import { t } from '../i18n';
import { complain, mayMove, request, status, ways } from '../state/cell';
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
  const devices = await request('hardware.list');
  const controllers = new Set<string>(names.filter((name) => !devices.some((each) => each.name === name)));
  for (const { name, state } of devices.filter((each) => names.includes(each.name))) {
    if (state === 'inactive' || state === 'unconfigured') {
      await request('hardware.state', { name, state: 'active' });
      continue;
    }
    const { fallen } = await request('hardware.recover', { name });
    for (const each of fallen ?? []) controllers.add(each);
  }
  if (controllers.size) await request('control.switch', { activate: [...controllers], deactivate: [] });
}
