/** One row per axis: minus, the value with its bar, plus. The robot moves while a key is pressed. */
import type { ComponentChildren } from 'preact';
import { t } from '../../i18n';
import { jogBlocked } from '../../state/cell';
import { heldKey, jogMode, pressJog, release, stepsToGo } from '../../state/jog';
import { beat } from '../../state/live';
import { canBe } from '../../state/ways';
import { jointText } from '../../ui/format';
import { Icon } from '../../ui/Icon';
import { type Axis, axesNow, nearLimit, roomTo } from './axes';

export function JogKeys() {
  beat.value;
  const blocked = !canBe(jogBlocked.value);
  const axes = axesNow();
  return (
    <div class={`jog-keys ${axes.length > 6 ? 'many' : ''}`} role="group" aria-label={t('move.axes')}>
      {axes.map((axis) => (
        <Row key={`${jogMode.value}/${axis.index}`} axis={axis} index={axis.index} blocked={blocked} />
      ))}
      <StepsToGo />
    </div>
  );
}

function Row({ axis, index, blocked }: { axis: Axis; index: number; blocked: boolean }) {
  return (
    <div class={`jog-row ${axis.color ?? ''}`}>
      <JogKey axis={axis} index={index} direction={-1} blocked={blocked} />
      <div class="jog-value">
        <span class="name">{axis.name}</span>
        <output aria-label={axis.name}>{jointText(axis.value, axis.unit, axis.unit === 'm' ? 1 : 2)}</output>
        {axis.joint && <JointBar axis={axis} />}
      </div>
      <JogKey axis={axis} index={index} direction={1} blocked={blocked} />
    </div>
  );
}

function JogKey(props: { axis: Axis; index: number; direction: 1 | -1; blocked: boolean }) {
  const { axis, index, direction, blocked } = props;
  const key = `${jogMode.value}/${index}/${direction}`;
  const room = axis.joint ? roomTo(axis.joint, axis.value, direction) : Infinity;
  const atLimit = room < 1e-3;
  const near = axis.joint !== undefined && room < nearLimit(axis.joint);
  const label = t(direction > 0 ? 'move.more' : 'move.less', { axis: axis.name });
  return (
    <HoldButton
      class={`jog-key ${near ? 'near' : ''}`}
      label={atLimit ? `${label}, ${t('move.atLimit')}` : label}
      held={heldKey.value === key}
      disabled={blocked || atLimit}
      onPress={() => pressJog(index, direction)}
      onRelease={release}
    >
      <Icon name={direction > 0 ? 'plus' : 'minus'} size={26} />
    </HoldButton>
  );
}

function StepsToGo() {
  return (
    <p class="jog-queue" role="status">
      {stepsToGo.value > 0 && t('move.queued', { count: stepsToGo.value })}
    </p>
  );
}

interface HoldProps {
  label: string;
  held: boolean;
  disabled?: boolean;
  class?: string;
  onPress: () => void;
  onRelease: () => void;
  children: ComponentChildren;
}

/** Acts while it is held, by pointer or by space and enter. Losing the pointer for any reason releases it. */
export function HoldButton(props: HoldProps) {
  const down = (e: PointerEvent) => {
    if (e.button !== 0 || props.disabled) return;
    e.preventDefault();
    const button = e.currentTarget as HTMLButtonElement;
    button.focus();
    button.setPointerCapture(e.pointerId);
    props.onPress();
  };
  const up = () => props.onRelease();
  const isKey = (e: KeyboardEvent) => e.key === ' ' || e.key === 'Enter';
  return (
    <button
      type="button"
      class={`hold ${props.held ? 'held' : ''} ${props.class ?? ''}`}
      aria-label={props.label}
      title={props.label}
      aria-pressed={props.held}
      disabled={props.disabled}
      onPointerDown={down}
      onPointerUp={up}
      onPointerCancel={up}
      onLostPointerCapture={up}
      onContextMenu={(e) => e.preventDefault()}
      onKeyDown={(e) => {
        if (!isKey(e)) return;
        e.preventDefault();
        if (!e.repeat) props.onPress();
      }}
      onKeyUp={(e) => isKey(e) && up()}
      onBlur={up}
    >
      {props.children}
    </button>
  );
}

/**
 * The position of a joint within its range. The ends are marked, and the distance to the nearer one is shown.
 */
function JointBar({ axis }: { axis: Axis }) {
  const joint = axis.joint!;
  const { lower, upper } = joint;
  const bounded = joint.type !== 'continuous' && Number.isFinite(upper - lower) && upper > lower;
  if (!bounded) return <span class="joint-bar endless" aria-hidden="true" />;
  const share = Math.max(0, Math.min(1, (axis.value - lower) / (upper - lower)));
  const room = Math.min(roomTo(joint, axis.value, 1), roomTo(joint, axis.value, -1));
  const near = room < nearLimit(joint);
  const edge = (100 * nearLimit(joint)) / (upper - lower);
  const range = t('move.range', { lower: jointText(lower, joint.unit, 0), upper: jointText(upper, joint.unit, 0) });
  return (
    <span
      class={`joint-bar ${near ? 'near' : ''}`}
      title={near ? t('move.left', { amount: jointText(room, joint.unit) }) : range}
      aria-hidden="true"
    >
      <span class="edge" style={{ left: '0', width: `${edge}%` }} />
      <span class="edge" style={{ right: '0', width: `${edge}%` }} />
      <span class="mark" style={{ left: `${100 * share}%` }} />
    </span>
  );
}
