import { t, languages } from '../i18n';
import { version } from '../state/cell';
import { type Language, settings, type Theme } from '../state/settings';
import { Field, Segmented, Select, Toggle } from '../ui/controls';
import { Dialog } from '../ui/Dialog';

const keys: [string, Parameters<typeof t>[0]][] = [
  ['Esc', 'keys.stop'],
  ['F8', 'keys.hold'],
  ['Alt + 1 … 8', 'keys.pages'],
  ['Q W E R T Y / A S D F G H', 'keys.jog'],
  ['M', 'keys.mode'],
  ['− / +', 'keys.faster'],
];

export function Menu({ onClose }: { onClose: () => void }) {
  return (
    <Dialog title={t('menu.label')} onClose={onClose} side>
      <div class="stack">
        <Select
          label={t('menu.language')}
          value={settings.language.value}
          options={[{ id: 'auto', name: t('menu.auto') }, ...languages]}
          onChange={(id) => (settings.language.value = id as Language)}
        />
        <div class="labelled">
          <span>{t('menu.theme')}</span>
          <Segmented<Theme>
            label={t('menu.theme')}
            value={settings.theme.value}
            options={[
              { id: 'auto', name: t('menu.auto') },
              { id: 'light', name: t('menu.light') },
              { id: 'dark', name: t('menu.dark') },
            ]}
            onChange={(theme) => (settings.theme.value = theme)}
          />
        </div>
        <div class="labelled">
          <span>{t('menu.units')}</span>
          <Segmented
            label={t('menu.units')}
            value={settings.degrees.value ? 'deg' : 'rad'}
            options={[
              { id: 'deg', name: t('menu.degrees') },
              { id: 'rad', name: t('menu.radians') },
            ]}
            onChange={(unit) => (settings.degrees.value = unit === 'deg')}
          />
        </div>
        <Field
          label={t('control.name')}
          value={settings.clientName.value}
          onChange={(name) => (settings.clientName.value = name.trim() || settings.clientName.value)}
        />
        <Toggle
          label={t('menu.take')}
          value={settings.takeWhenFree.value}
          onChange={(on) => (settings.takeWhenFree.value = on)}
        />
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
        {version.value && <p class="note">{t('menu.version', { version: version.value })}</p>}
      </div>
    </Dialog>
  );
}
