/** Jog settings: what moves, in which frame, how fast and how far. */
import { useEffect } from 'preact/hooks';
import { t } from '../../i18n';
import { mayMove, robot } from '../../state/cell';
import { jogMode, jogSpeed, jogStep, type JogMode, stepDegrees, userFrame } from '../../state/jog';
import { frames } from '../../state/models';
import { number } from '../../i18n';
import { Segmented, Select, Slider } from '../../ui/controls';

const kSteps = [0.1, 1, 10, 50];

/** The name of a step, in mm, degrees or both, depending on what is jogged. */
function stepName(step: number): string {
  if (step === 0) return t('move.hold');
  const digits = step < 1 ? 1 : 0;
  const deg = number(stepDegrees(step), digits);
  const turnsOnly = jogMode.value === 'joint' && !robot.value?.joints.some((joint) => joint.unit === 'm');
  return turnsOnly ? t('move.stepAngle', { deg }) : t('move.stepOf', { mm: number(step, digits), deg });
}

/** Changes the jog mode. For the mode `user`, selects a frame that exists. */
export function chooseMode(mode: JogMode): void {
  const known = frames.peek();
  if (mode === 'user' && !known.some((frame) => frame.name === userFrame.peek())) userFrame.value = known[0]!.name;
  jogMode.value = mode;
}

export function JogSettings() {
  const known = frames.value;
  // The selected frame may belong to another cell, or may have been deleted.
  useEffect(() => {
    if (jogMode.value === 'user' && known.length && !known.some((frame) => frame.name === userFrame.value)) chooseMode('user');
    if (jogMode.value === 'drive' && !robot.value?.drives) chooseMode('joint');
  }, [known, jogMode.value, robot.value]);
  const modes: { id: JogMode; name: string }[] = [
    { id: 'joint', name: t('move.joint') },
    { id: 'base', name: t('move.base') },
    { id: 'tool', name: t('move.tool') },
    { id: 'world', name: t('move.world') },
  ];
  if (robot.value?.drives) modes.push({ id: 'drive', name: t('move.drive') });
  if (known.length) modes.push({ id: 'user', name: t('move.user') });
  // Two steps may turn by the same angle. If all joints turn, only one of them is offered.
  const steps = [0, ...kSteps].map((step) => ({ id: String(step), name: stepName(step) })).filter((each, i, all) => all.findIndex((other) => other.name === each.name) === i);
  return (
    <div class="jog-settings">
      <Segmented<JogMode>
        label={t('move.frame')}
        value={jogMode.value}
        options={modes}
        onChange={chooseMode}
      />
      {jogMode.value === 'user' && known.length > 0 && (
        <Select
          label={t('move.chooseFrame')}
          value={userFrame.value}
          options={known.map((frame) => ({ id: frame.name, name: frame.name }))}
          onChange={(name) => (userFrame.value = name)}
        />
      )}
      <div class="jog-how">
        <Select
          label={t('move.step')}
          value={steps.find((each) => each.name === stepName(jogStep.value))?.id ?? '0'}
          options={steps}
          onChange={(step) => (jogStep.value = Number(step))}
        />
        <Slider
          label={t('move.speed')}
          value={jogSpeed.value}
          min={1}
          max={100}
          unit="%"
          disabled={!mayMove.value}
          onInput={(speed) => (jogSpeed.value = speed)}
        />
      </div>
    </div>
  );
}
