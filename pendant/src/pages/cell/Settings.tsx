/** Settings of this screen: its look and its name. They do not change the cell. */
import { t } from '../../i18n';
import { Looks, Screen } from '../../shell/ScreenSettings';
import { settings } from '../../state/settings';
import { Card, Toggle } from '../../ui/controls';

export function SettingsTab() {
  return (
    <div class="cell-grid">
      <Card title={t('cell.screen')}>
        <Screen />
        <Toggle label={t('cell.leftHanded')} value={settings.leftHanded.value} onChange={(on) => (settings.leftHanded.value = on)} />
      </Card>
      <Card title={t('cell.looks')}>
        <Looks />
      </Card>
    </div>
  );
}
