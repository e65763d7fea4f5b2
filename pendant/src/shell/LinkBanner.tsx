import { t } from '../i18n';
import { link } from '../state/cell';
import { signal } from '@preact/signals';
import { Icon } from '../ui/Icon';

/** The first connection takes longer than it should; later ones are always told. */
const late = signal(false);
setTimeout(() => (late.value = true), 1500);

/** Says that what is shown is old. Not shown in the first moments, before anything could have been lost. */
export function LinkBanner() {
  const state = link.value;
  if (state === 'open' || (state === 'connecting' && !late.value)) return null;
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
