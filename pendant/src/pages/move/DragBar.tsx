/** Dragging the TCP by a handle in the picture: the robot follows as long as the handle is held. */
import { effect, signal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { t } from '../../i18n';
import { complain, mayMove, request, robot } from '../../state/cell';
import { jogMode, jogSpeed } from '../../state/jog';
import { beat } from '../../state/live';
import { Button } from '../../ui/controls';
import { handle } from '../../view3d/RobotView';
import type { Json } from '../../wire/connection';
import type { Pose } from '../../wire/types';
import { tcpPose } from './axes';
import { programMoves } from './JogKeys';

const dragging = signal(false);
const turning = signal(false);
const kEveryMs = 50;
/** Longer than a beat may be late, shorter than what a person would notice. */
const kHoldS = 0.15;

let session: number | null = null;
let wanted: Pose | null = null;
let held = false;
let timer: ReturnType<typeof setInterval> | undefined;
let underway = 0;

async function send(): Promise<void> {
  if (!wanted || underway > 3) return;
  ++underway;
  const { p, q } = wanted;
  const args: Json = {
    robot: robot.peek()?.name ?? '',
    pose: { position: p, orientation: q },
    frame: 'world',
    speed: jogSpeed.peek() / 100,
    hold: kHoldS,
  };
  if (session !== null) args.session = session;
  try {
    const answer = await request<{ session?: number }>('target', args, 2_000);
    if (held && answer.session !== undefined) session = answer.session;
  } catch (error) {
    if (held) complain(error);
    letGo();
  } finally {
    --underway;
  }
}

function hold(down: boolean): void {
  if (!down) return letGo();
  held = true;
  session = null;
  timer = setInterval(() => void send(), kEveryMs);
}

function letGo(): void {
  held = false;
  wanted = null;
  clearInterval(timer);
  timer = undefined;
}
addEventListener('blur', letGo);
document.addEventListener('visibilitychange', () => {
  if (document.visibilityState !== 'visible') letGo();
});
effect(() => {
  if (!mayMove.value) letGo();
});

export function DragBar() {
  const on = dragging.value && mayMove.value && !programMoves();
  useEffect(() => () => ((dragging.value = false), letGo(), (handle.value = null)), []);
  beat.value;
  useEffect(() => {
    if (!on) {
      handle.value = null;
      return;
    }
    const pose = tcpPose();
    if (!pose.p.every(Number.isFinite) || held) return;
    handle.value = {
      pose,
      turn: turning.value,
      local: jogMode.value === 'tool',
      onDrag: (to) => (wanted = to),
      onHold: hold,
    };
  });
  return (
    <>
      <Button
        label={t('move.drag')}
        icon="hand"
        title={t('move.dragWhy')}
        pressed={dragging.value}
        disabled={!mayMove.value || programMoves()}
        onClick={() => (dragging.value = !dragging.value)}
      />
      {on && (
        <>
          <Button label={t('move.dragLine')} icon="move" pressed={!turning.value} onClick={() => (turning.value = false)} />
          <Button label={t('move.dragTurn')} icon="turnRight" pressed={turning.value} onClick={() => (turning.value = true)} />
        </>
      )}
    </>
  );
}
