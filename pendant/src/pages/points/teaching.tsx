/**
 * The points that the wizards have recorded so far. They are kept while the user moves the robot on the Move
 * page, which leads back to the wizard. Each robot has its own: samples of two robots make no tool and no camera.
 */
import { signal } from '@preact/signals';
import { t } from '../../i18n';
import { WatchOnly } from '../../shell/Control';
import { go } from '../../shell/route';
import { cell, robot, robotName } from '../../state/cell';
import { close, open } from '../../ui/ask';
import { Button, Segmented } from '../../ui/controls';
import { Icon } from '../../ui/Icon';
import type { Pose, Vec3 } from '../../wire/types';
import { ofRobot } from './samples';

export const kNoTouches: (Vec3 | null)[] = [null, null, null];
export const touches = ofRobot(kNoTouches);
export const toolPoses = ofRobot<Pose[]>([]);
export interface Sighting {
  flange: Pose;
  marker: Pose;
}
export const sightings = ofRobot<Sighting[]>([]);
/** What a wizard says first: why nothing can be saved, and with several robots whose places it takes. */
export function Whose() {
  const robots = cell.value?.robots ?? [];
  return (
    <>
      <WatchOnly needs="program" />
      {robots.length > 1 && (
        <Segmented label={t('move.robot')} value={robot.value?.name ?? ''} options={robots.map((each) => ({ id: each.name, name: each.name }))} onChange={(name) => (robotName.value = name)} />
      )}
    </>
  );
}

/** The wizard that waits while the user moves the robot. */
type Kind = 'frame' | 'tool' | 'camera';
export const waiting = signal<Kind | null>(null);

/** What each wizard is called, and how many places it needs. */
const kWizards = {
  frame: { title: 'points.frame', icon: 'cube', least: 3 },
  tool: { title: 'points.tool', icon: 'target', least: 4 },
  camera: { title: 'points.camera', icon: 'eye', least: 3 },
} as const;

/** A button that leads to the Move page and keeps the wizard waiting. */
export function MoveButton({ kind }: { kind: Kind }) {
  const move = () => {
    waiting.value = kind;
    close();
    go('move');
  };
  return <Button label={t('points.moveThere')} icon="move" onClick={move} />;
}

async function goOn(kind: Kind): Promise<void> {
  if (kind === 'frame') {
    const { FrameWizard } = await import('./FrameWizard');
    open((done) => <FrameWizard onClose={done} />);
  } else if (kind === 'camera') {
    const { CameraWizard } = await import('./CameraWizard');
    open((done) => <CameraWizard onClose={done} />);
  } else {
    const { ToolWizard } = await import('./ToolWizard');
    open((done) => <ToolWizard onClose={done} />);
  }
}

/** A banner on the Move page that leads back to the wizard. */
export function WaitingWizard() {
  const kind = waiting.value;
  if (!kind) return null;
  const { title, icon, least } = kWizards[kind];
  const count = kind === 'frame' ? touches.value.filter(Boolean).length : kind === 'tool' ? toolPoses.value.length : sightings.value.length;
  return (
    <div class="banner" role="status">
      <Icon name={icon} />
      <div>
        <strong>{t(title)}</strong> · {t(kind === 'camera' ? 'points.countSeen' : 'points.countTouched', { count, of: least })}
      </div>
      <Button label={t(kind === 'camera' ? 'points.seeNow' : 'points.touchNow')} tone="primary" onClick={() => void goOn(kind)} />
      <Button label={t('dialog.close')} icon="close" bare tone="quiet" onClick={() => (waiting.value = null)} />
    </div>
  );
}
