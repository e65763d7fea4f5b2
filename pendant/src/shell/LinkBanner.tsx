import { t } from '../i18n';
import { link, status } from '../state/cell';
import { Icon } from '../ui/Icon';

/** Says that what is shown is old. Not shown in the first moments, before anything could have been lost. */
export function LinkBanner() {
  const state = link.value;
  if (state === 'open' || (state === 'connecting' && status.value === null && performance.now() < 1500)) return null;
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
