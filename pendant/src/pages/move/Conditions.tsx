/**
 * One line about what restricts the robot: the restriction that the cell reports during a motion, else a
 * limit or singularity nearby.
 */
import { computed } from '@preact/signals';
import { t } from '../../i18n';
import { bodyWords } from '../../i18n/told';
import { connected, jogBlocked, mayTake, robot, status } from '../../state/cell';
import { heldBack, jogMode } from '../../state/jog';
import { beat, valueNow } from '../../state/live';
import { chain, jointValues } from '../../state/models';
import { Icon } from '../../ui/Icon';
import { blockedWords } from '../../shell/blocked';
import { touchOf } from '../../shell/contact';
import { jointTitle } from '../../ui/format';
import { nearLimit, roomTo } from './axes';
import { heldWords } from './held';

/**
 * Values of Chain.smallestGain. Near a singularity (below kNear) the cell slows the TCP down; below kAt the
 * TCP hardly moves.
 */
const kNear = 0.09;
const kAt = 0.01;

/** 0 far from every singularity, 1 at a singularity; NaN if unknown. */
export const singularity = computed(() => {
  beat.value;
  if (!connected.value) return NaN;
  const name = robot.value?.name ?? '';
  const gain = chain.value?.smallestGain(jointValues(name)) ?? NaN;
  if (!Number.isFinite(gain)) return NaN;
  return Math.max(0, Math.min(1, 1 - (gain - kAt) / (2 * kNear - kAt)));
});

interface Condition {
  tone: 'good' | 'warn' | 'bad' | 'off';
  text: string;
}

function condition(): Condition {
  if (!connected.value) return { tone: 'off', text: '–' };
  if (jogBlocked.value === 'why.control') return { tone: 'off', text: t(mayTake.value ? 'control.needed' : 'control.roleWatch') };
  const blocked = blockedWords(jogBlocked.value);
  if (blocked) return { tone: 'warn', text: blocked };
  const held = heldWords();
  if (held) return { tone: heldBack.value?.what === 'singular' ? 'bad' : 'warn', text: held };
  const touch = touchOf(robot.value?.name ?? '', status.value?.contacts.list ?? []);
  if (touch) return { tone: 'bad', text: t('move.touching', { a: bodyWords(touch.a), b: bodyWords(touch.b) }) };
  return nearby();
}

function nearby(): Condition {
  const share = singularity.value;
  if (jogMode.value !== 'joint' && share >= 1) return { tone: 'bad', text: t('move.singularAt') };
  for (const joint of robot.value?.joints ?? []) {
    const value = valueNow(`${joint.interface}/position`);
    const room = Math.min(roomTo(joint, value, 1), roomTo(joint, value, -1));
    const words = { joint: jointTitle(joint.name) };
    if (room < 1e-3) return { tone: 'warn', text: t('move.limitAt', words) };
    if (room < nearLimit(joint)) return { tone: 'warn', text: t('move.limitNear', words) };
  }
  if (share > 0.5) return { tone: 'warn', text: t('move.singularNear') };
  return { tone: 'good', text: t('move.free') };
}

export function Conditions() {
  beat.value;
  const now = condition();
  const share = singularity.value;
  return (
    <div class={`conditions ${now.tone}`} role="status">
      <Icon name={now.tone === 'good' ? 'check' : 'alarm'} size={20} />
      <span class="grow">{now.text}</span>
      {Number.isFinite(share) && (
        <span class="singular">
          <span>{t('move.singular')}</span>
          <meter min={0} max={1} low={0.5} high={0.95} optimum={0} value={share} aria-label={t('move.singular')}>
            {Math.round(100 * share)} %
          </meter>
        </span>
      )}
    </div>
  );
}

