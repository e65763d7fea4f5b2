/** The page of the whole cell: its robot, simulation or real robot, projects, settings. */
import { signal } from '@preact/signals';
import { t } from '../../i18n';
import { WatchOnly } from '../../shell/Control';
import { Segmented } from '../../ui/controls';
import './cell.css';
import { Catalogue } from './Catalogue';
import { Overview } from './Overview';
import { Projects } from './Projects';
import { SettingsTab } from './Settings';

type Tab = 'cell' | 'robot' | 'projects' | 'settings';
export const tab = signal<Tab>('cell');

export default function Page() {
  return (
    <div class="cell-page">
      <WatchOnly needs="administer" />
      <Segmented<Tab>
        label={t('cell.shown')}
        value={tab.value}
        options={[
          { id: 'cell', name: t('nav.cell') },
          { id: 'robot', name: t('cell.robots') },
          { id: 'projects', name: t('cell.projects') },
          { id: 'settings', name: t('menu.label') },
        ]}
        onChange={(id) => (tab.value = id)}
      />
      <div class="cell-body" tabIndex={0} role="region" aria-label={t('nav.cell')}>
        {tab.value === 'cell' && <Overview onRobots={() => (tab.value = 'robot')} onProjects={() => (tab.value = 'projects')} />}
        {tab.value === 'robot' && <Catalogue onDone={() => (tab.value = 'cell')} />}
        {tab.value === 'projects' && <Projects />}
        {tab.value === 'settings' && <SettingsTab />}
      </div>
    </div>
  );
}
