/** The health of the cell: loop, hardware, controllers, active limits, alarms, log. */
import { useEffect } from 'preact/hooks';
import { t } from '../../i18n';
import { alarms, connected } from '../../state/cell';
import { followHealth } from '../../state/health';
import { kept } from '../../state/settings';
import { Empty, Segmented } from '../../ui/controls';
import { AlarmList, LogList } from './Events';
import './health.css';
import { Controllers, Hardware } from './Machines';
import { Loop } from './Loop';

type Tab = 'loop' | 'hardware' | 'controllers' | 'alarms' | 'log';
/** What they show has happened, and stays true without a connection. */
const kPast: Tab[] = ['alarms', 'log'];
const tab = kept<Tab>('health.tab', 'loop');

export default function Page() {
  useEffect(followHealth, []);
  const bodies = { loop: Loop, hardware: Hardware, controllers: Controllers, alarms: AlarmList, log: LogList };
  const Body = bodies[tab.value] ?? Loop;
  const count = alarms.value.length;
  return (
    <div class="health-page">
      <Segmented<Tab>
        label={t('health.shown')}
        value={tab.value}
        options={[
          { id: 'loop', name: t('health.loop') },
          { id: 'hardware', name: t('health.hardware') },
          { id: 'controllers', name: t('health.controllers') },
          { id: 'alarms', name: count ? `${t('alarms.label')} (${count})` : t('alarms.label') },
          { id: 'log', name: t('health.log') },
        ]}
        onChange={(id) => (tab.value = id)}
      />
      <div class="health-body" tabIndex={0} role="region" aria-label={t('nav.health')}>
        {connected.value || kPast.includes(tab.value) ? <Body /> : <Empty icon="link" text={t('why.offline')} />}
      </div>
    </div>
  );
}
