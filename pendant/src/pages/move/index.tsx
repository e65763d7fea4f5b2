/** Manual motion: the picture beside the keys, and above them what restricts the robot. */
import { t } from '../../i18n';
import { cell, mayMove, robot, robotName } from '../../state/cell';
import { open } from '../../ui/ask';
import { Button, Empty, Segmented } from '../../ui/controls';
import { WatchOnly } from '../../shell/Control';
import { WaitingWizard } from '../points/teaching';
import { RobotView } from '../../view3d/RobotView';
import { Conditions } from './Conditions';
import { DragBar } from './DragBar';
import { GoTo } from './GoTo';
import { Inputs } from './Inputs';
import { JogKeys } from './JogKeys';
import { JogSettings } from './JogSettings';
import { Where } from './Where';
import './move.css';

export default function MovePage() {
  const robots = cell.value?.robots ?? [];
  if (!robot.value) return <Empty icon="move" text={t('page.loading')} />;
  return (
    <div class="move">
      <div class="move-banners">
        <WatchOnly />
        <WaitingWizard />
      </div>
      <div class="move-picture">
        <RobotView />
        <div class="move-tools">
          <DragBar />
          <Button
            label={t('move.goto')}
            icon="target"
            disabled={!mayMove.value}
            onClick={() => open((close) => <GoTo onClose={close} />)}
          />
          <Inputs />
        </div>
        <Conditions />
        <Where />
      </div>
      <div class="move-panel">
        {robots.length > 1 && (
          <Segmented
            label={t('move.robot')}
            value={robot.value.name}
            options={robots.map((each) => ({ id: each.name, name: each.name }))}
            onChange={(name) => (robotName.value = name)}
          />
        )}
        <JogSettings />
        <JogKeys />
      </div>
    </div>
  );
}
