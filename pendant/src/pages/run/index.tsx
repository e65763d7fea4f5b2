/** The Run page: what the program does now, in large letters, and the few keys to control it. */
import { t } from '../../i18n';
import { RobotView } from '../../view3d/RobotView';
import { WatchOnly } from '../../shell/Control';
import { Choice } from './Choice';
import { Figures } from './Figures';
import { Keys } from './Keys';
import { Now } from './Now';
import { Text } from './Text';
import './run.css';

export default function RunPage() {
  return (
    <div class="run">
      <WatchOnly />
      <div class="run-picture">
        <RobotView />
      </div>
      <section class="run-panel" aria-label={t('run.title')}>
        <Now />
        <Choice />
        <Keys />
        <Figures />
        <Text />
      </section>
    </div>
  );
}
