import { t } from '../i18n';
import { link } from '../state/cell';
import { signal } from '@preact/signals';
import { loopStands, waitsFor } from '../state/standing';
import { Icon } from '../ui/Icon';
import { LogIn, mustLogIn } from './LogIn';

/** True after the time that a first connection normally takes. Later losses are shown immediately. */
const late = signal(false);
setTimeout(() => (late.value = true), 1500);

/** Warns that the shown values are old. Hidden during the first connection, when there are no values yet. */
export function LinkBanner() {
  const state = link.value;
  if (state === 'open') return loopStands.value ? <Stands /> : null;
  // Before the rest: the form keeps what was typed while the page tries to connect.
  if (mustLogIn.value) return <LogIn />;
  if (state === 'connecting' && !late.value) return null;
  const refused = state === 'refused';
  return (
    <div class="banner bad" role="alert">
      <Icon name="link" />
      <div>
        <strong>{t(refused ? 'link.refused' : 'link.lost')}</strong>
        <p>{t(refused ? 'link.refusedWhy' : 'link.lostWhy')}</p>
      </div>
    </div>
  );
}

function Stands() {
  const name = waitsFor();
  return (
    <div class="banner bad" role="alert">
      <Icon name="alarm" />
      <div>
        <strong>{t('state.stands')}</strong>
        <p>{[name && `${t('state.standsFor', { name })}.`, t('state.standsWhy')].filter(Boolean).join(' ')}</p>
      </div>
    </div>
  );
}
