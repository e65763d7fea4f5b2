import { t } from '../i18n';
import { dismiss, toasts } from '../state/toasts';
import { Button } from './controls';
import { Icon, type IconName } from './Icon';

const icons: Record<string, IconName> = { ok: 'check', info: 'eye', warning: 'alarm', error: 'alarm' };

export function Toasts() {
  return (
    <div class="toasts" role="region" aria-label={t('toast.label')} aria-live="polite">
      {toasts.value.map((each) => (
        <div key={each.id} class={`toast ${each.kind}`} role={each.kind === 'error' ? 'alert' : 'status'}>
          <Icon name={icons[each.kind] ?? 'eye'} size={22} />
          <div>
            <p>{each.text}</p>
            {each.detail && <p class="detail">{each.detail}</p>}
          </div>
          <Button label={t('toast.dismiss')} icon="close" bare tone="quiet" onClick={() => dismiss(each.id)} />
        </div>
      ))}
    </div>
  );
}
