/** Moves to a goal: the cell plans the way, the page shows it, and the robot moves while the key is held. */
import type { PlanPreviewAnswer } from '../../wire/requests';
import { useEffect, useState } from 'preact/hooks';
import { number, t } from '../../i18n';
import { type Problem, problemLine, problemOf } from '../../i18n/told';
import { jogBlocked, request, robot } from '../../state/cell';
import { heldKey, pressGoTo, release } from '../../state/jog';
import { beat } from '../../state/live';
import { jointValues } from '../../state/models';
import { Segmented } from '../../ui/controls';
import { Icon } from '../../ui/Icon';
import { preview } from '../../view3d/RobotView';
import type { Json } from '../../wire/connection';
import type { Pose, Vec3 } from '../../wire/types';
import { heldWords } from './held';
import { HoldButton } from './JogKeys';
import { blockedWords } from '../../shell/blocked';
import { canBe } from '../../state/ways';
import './go.css';

/** A pose in the world, or joint values by name. */
export type Goal = { joints: Record<string, number> } | { pose: Pose };

interface Dry {
  /** The request, as text, to which this result belongs. */
  of: string;
  ok: boolean;
  reason?: Problem;
  path?: Vec3[];
  seconds?: number;
  joints?: Record<string, number>;
}

/**
 * Shorter ways count as already there, s. They cover a few tenths of a millimetre, which a manual motion may
 * leave.
 */
const kThere = 0.1;
const kWaitMs = 150;

/** `goal`: null if there is no goal yet. */
export function GoKey({ goal }: { goal: Goal | null }) {
  const [way, setWay] = useState<'joint' | 'line'>('joint');
  const [dry, setDry] = useState<Dry | null>(null);
  const args: Json | null = goal && robot.value ? { robot: robot.value.name, kind: way, ...goal } : null;
  const moving = heldKey.value === 'goto';
  const held = heldWords();
  // Reading the beat plans the way again after the robot has moved.
  beat.value;
  const now = jointValues(robot.value?.name ?? '');
  const from = (robot.value?.joints ?? []).map((joint) => Math.round(100 * now(joint.name))).join(' ');
  const wish = args ? JSON.stringify(args) : '';
  const known = dry?.of === wish ? dry : null;
  useEffect(() => {
    if (moving) return;
    if (!known) preview.value = null;
    if (!args) return;
    let gone = false;
    const timer = setTimeout(() => {
      request('jog.goto', { ...args, dry: true }).then(
        (answer) => {
          const { ok, path, seconds, joints } = answer as PlanPreviewAnswer;  // the answer of a request with `dry`
          if (gone) return;
          setDry({ ok, path, seconds, joints, of: wish });
          preview.value = ok ? { robot: robot.peek()!.name, path, joints } : null;
        },
        (error: Error) => {
          if (gone) return;
          setDry({ ok: false, reason: problemOf(error), of: wish });
          preview.value = null;
        },
      );
    }, kWaitMs);
    return () => {
      gone = true;
      clearTimeout(timer);
    };
  }, [wish, moving ? '' : from, moving]);
  useEffect(
    () => () => {
      release();
      preview.value = null;
    },
    [],
  );
  return (
    <div class="go-key">
      <Segmented
        label={t('goto.way')}
        value={way}
        options={[
          { id: 'joint', name: t('goto.wayJoint') },
          { id: 'line', name: t('goto.wayLine') },
        ]}
        onChange={setWay}
      />
      <HoldButton
        class="go-hold"
        label={t(moving ? 'goto.moving' : 'goto.move')}
        held={moving}
        disabled={!args || !canBe(jogBlocked.value) || (!moving && !known?.ok)}
        onPress={() => args && pressGoTo(args)}
        onRelease={release}
      >
        <Icon name="target" size={22} />
        {t(moving ? 'goto.moving' : 'goto.move')}
      </HoldButton>
      <p class="note go-words" role="status">
        {known?.reason && !known.ok && <span class="problem-text">{problemLine(known.reason)}</span>}
        {known?.ok && !moving && wordsOf(known)}
        {held && <span class="problem-text">{held}</span>}
        {blockedWords(jogBlocked.value) && <span class="problem-text">{blockedWords(jogBlocked.value)}</span>}
      </p>
    </div>
  );
}

function wordsOf({ seconds }: Dry): string {
  if (seconds === undefined) return '';
  return seconds < kThere ? t('goto.arrived') : `${t('goto.preview')} (${t('goto.seconds', { seconds: number(seconds, 1) })})`;
}
