/** Drags the TCP by a handle in the picture. The robot follows while the handle is held. */
import { signal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { t } from '../../i18n';
import { jogBlocked } from '../../state/cell';
import { dragHandle, heldKey, holdHandle, jogMode, release } from '../../state/jog';
import { beat } from '../../state/live';
import { canBe } from '../../state/ways';
import { Button } from '../../ui/controls';
import { handle } from '../../view3d/RobotView';
import { tcpPose } from './axes';

const dragging = signal(false);
const turning = signal(false);
export function DragBar() {
  const on = dragging.value && canBe(jogBlocked.value);
  useEffect(() => () => ((dragging.value = false), release(), (handle.value = null)), []);
  beat.value;
  useEffect(() => {
    if (!on) {
      handle.value = null;
      return;
    }
    const pose = tcpPose();
    if (!pose.p.every(Number.isFinite) || heldKey.peek() === 'handle') return;
    handle.value = {
      pose,
      turn: turning.value,
      local: jogMode.value === 'tool',
      onDrag: (to) => dragHandle(to.p, to.q),
      onHold: (held) => (held ? holdHandle() : release()),
    };
  });
  return (
    <>
      <Button
        label={t('move.drag')}
        icon="hand"
        title={t('move.dragWhy')}
        pressed={dragging.value}
        disabled={!canBe(jogBlocked.value)}
        onClick={() => (dragging.value = !dragging.value)}
      />
      {on && (
        <>
          <Button label={t('move.dragLine')} icon="move" bare pressed={!turning.value} onClick={() => (turning.value = false)} />
          <Button label={t('move.dragTurn')} icon="turnRight" bare pressed={turning.value} onClick={() => (turning.value = true)} />
        </>
      )}
    </>
  );
}
