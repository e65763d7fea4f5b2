/** The look and the name of this screen, as two groups of fields. They do not change the cell. */
import { languages, t } from '../i18n';
import { type Language, settings, type Theme } from '../state/settings';
import { Field, Segmented, Select, Toggle } from '../ui/controls';

export function Looks() {
  return (
    <>
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
    </>
  );
}

export function Screen() {
  return (
    <>
      <Field label={t('control.name')} value={settings.clientName.value} onChange={(name) => (settings.clientName.value = name.trim() || settings.clientName.value)} />
      <Toggle label={t('menu.take')} value={settings.takeWhenFree.value} onChange={(on) => (settings.takeWhenFree.value = on)} />
    </>
  );
}
