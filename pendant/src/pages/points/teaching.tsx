/**
 * The points that the wizards have recorded so far. They are kept while the user moves the robot on the Move
 * page, which leads back to the wizard.
 */
import { signal } from '@preact/signals';
import { t } from '../../i18n';
import { go } from '../../shell/route';
import { close, open } from '../../ui/ask';
import { Button } from '../../ui/controls';
import { Icon } from '../../ui/Icon';
import type { Pose, Vec3 } from '../../wire/types';

export const kNoTouches: (Vec3 | null)[] = [null, null, null];
export const touches = signal(kNoTouches);
export const toolPoses = signal<Pose[]>([]);
/** The wizard that waits while the user moves the robot. */
export const waiting = signal<'frame' | 'tool' | null>(null);

/** A button that leads to the Move page and keeps the wizard waiting. */
export function MoveButton({ kind }: { kind: 'frame' | 'tool' }) {
  const move = () => {
    waiting.value = kind;
    close();
    go('move');
  };
  return <Button label={t('points.moveThere')} icon="move" onClick={move} />;
}

async function goOn(kind: 'frame' | 'tool'): Promise<void> {
  if (kind === 'frame') {
    const { FrameWizard } = await import('./FrameWizard');
    open((done) => <FrameWizard onClose={done} />);
  } else {
    const { ToolWizard } = await import('./ToolWizard');
    open((done) => <ToolWizard onClose={done} />);
  }
}

/** A banner on the Move page that leads back to the wizard. */
export function WaitingWizard() {
  const kind = waiting.value;
  if (!kind) return null;
  const count = kind === 'frame' ? touches.value.filter(Boolean).length : toolPoses.value.length;
  return (
    <div class="banner" role="status">
      <Icon name={kind === 'frame' ? 'cube' : 'target'} />
      <div>
        <strong>{t(kind === 'frame' ? 'points.frame' : 'points.tool')}</strong> · {t('points.countTouched', { count, of: kind === 'frame' ? 3 : 4 })}
      </div>
      <Button label={t('points.touchNow')} tone="primary" onClick={() => void goOn(kind)} />
      <Button label={t('dialog.close')} icon="close" bare tone="quiet" onClick={() => (waiting.value = null)} />
    </div>
  );
}
