import { t } from '../i18n';
import { version } from '../state/cell';
import { Dialog } from '../ui/Dialog';
import { LoggedIn } from './LogIn';
import { Looks, Screen } from './ScreenSettings';

const keys: [string, Parameters<typeof t>[0]][] = [
  ['Esc', 'keys.stop'],
  ['F8', 'keys.hold'],
  ['Alt + 1 … 8', 'keys.pages'],
  ['Q W E R T Y U I / A S D F G H J K', 'keys.jog'],
  ['M', 'keys.mode'],
  ['− / +', 'keys.faster'],
  ['Ctrl + M', 'keys.tab'],
];

export function Menu({ onClose }: { onClose: () => void }) {
  return (
    <Dialog title={t('menu.label')} onClose={onClose} side>
      <div class="stack">
        <LoggedIn />
        <Looks />
        <Screen />
        <section aria-label={t('menu.keys')}>
          <h3>{t('menu.keys')}</h3>
          <dl class="keys">
            {keys.map(([key, text]) => (
              <div key={key}>
                <dt>
                  <kbd>{key}</kbd>
                </dt>
                <dd>{t(text)}</dd>
              </div>
            ))}
          </dl>
        </section>
        <p>
          <a href="/help/" target="polyarm-help">
            {t('help.all')}
          </a>
        </p>
        {version.value && <p class="note">{t('menu.version', { version: version.value })}</p>}
      </div>
    </Dialog>
  );
}
