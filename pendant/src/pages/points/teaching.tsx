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
import type { CalibrateSampleAnswer } from '../../wire/requests';
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
/** Samples of calibrate.sample: what the hand weighs, and where a device sees it. */
export const weighings = ofRobot<CalibrateSampleAnswer[]>([]);
export interface ArmPose {
  joints: Record<string, number>;
  measured: Pose;
}
export const armPoses = ofRobot<ArmPose[]>([]);
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
type Kind = 'frame' | 'tool' | 'camera' | 'payload' | 'joints';
export const waiting = signal<Kind | null>(null);

/** What each wizard is called, how many places it needs and has, and the words for them. */
const kTouched = { counted: 'points.countTouched', now: 'points.touchNow' } as const;
const kSeen = { counted: 'points.countSeen', now: 'points.seeNow' } as const;
const kMeasured = { counted: 'calibrate.count', now: 'points.seeNow' } as const;
const kWizards = {
  frame: { title: 'points.frame', icon: 'cube', least: 3, count: () => touches.value.filter(Boolean).length, ...kTouched },
  tool: { title: 'points.tool', icon: 'target', least: 4, count: () => toolPoses.value.length, ...kTouched },
  camera: { title: 'points.camera', icon: 'eye', least: 3, count: () => sightings.value.length, ...kSeen },
  payload: { title: 'calibrate.payload', icon: 'cube', least: 6, count: () => weighings.value.length, ...kMeasured },
  joints: { title: 'calibrate.joints', icon: 'settings', least: 30, count: () => armPoses.value.length, ...kMeasured },
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

const kLoads = {
  frame: async () => (await import('./FrameWizard')).FrameWizard,
  tool: async () => (await import('./ToolWizard')).ToolWizard,
  camera: async () => (await import('./CameraWizard')).CameraWizard,
  payload: async () => (await import('./PayloadWizard')).PayloadWizard,
  joints: async () => (await import('./JointsWizard')).JointsWizard,
};

export async function openWizard(kind: Kind): Promise<void> {
  const Wizard = await kLoads[kind]();
  open((done) => <Wizard onClose={done} />);
}

/** A banner on the Move page that leads back to the wizard. */
export function WaitingWizard() {
  const kind = waiting.value;
  if (!kind) return null;
  const { title, icon, least, count, counted, now } = kWizards[kind];
  return (
    <div class="banner" role="status">
      <Icon name={icon} />
      <div>
        <strong>{t(title)}</strong> · {t(counted, { count: count(), of: least })}
      </div>
      <Button label={t(now)} tone="primary" onClick={() => void openWizard(kind)} />
      <Button label={t('dialog.close')} icon="close" bare tone="quiet" onClick={() => (waiting.value = null)} />
    </div>
  );
}
