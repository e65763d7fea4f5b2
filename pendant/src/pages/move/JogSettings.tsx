/** What is moved, in which frame, how fast and how far. */
import { t } from '../../i18n';
import { mayMove } from '../../state/cell';
import { jogMode, jogSpeed, jogStep, type JogMode, userFrame } from '../../state/jog';
import { frames } from '../../state/models';
import { number } from '../../i18n';
import { Segmented, Select, Slider } from '../../ui/controls';

const kSteps = [0.1, 1, 10, 50];

/** A step in mm; turning takes at most 5°. */
export function stepDegrees(step: number): number {
  return Math.min(step, 5);
}

export function JogSettings() {
  const known = frames.value;
  const modes: { id: JogMode; name: string }[] = [
    { id: 'joint', name: t('move.joint') },
    { id: 'base', name: t('move.base') },
    { id: 'tool', name: t('move.tool') },
    { id: 'world', name: t('move.world') },
  ];
  if (known.length) modes.push({ id: 'user', name: t('move.user') });
  return (
    <div class="jog-settings">
      <Segmented<JogMode>
        label={t('move.frame')}
        value={jogMode.value}
        options={modes}
        onChange={(mode) => {
          if (mode === 'user' && !known.some((frame) => frame.name === userFrame.value)) userFrame.value = known[0]!.name;
          jogMode.value = mode;
        }}
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
          value={String(jogStep.value)}
          options={[
            { id: '0', name: t('move.hold') },
            ...kSteps.map((step) => ({
              id: String(step),
              name:
                jogMode.value === 'joint'
                  ? t('move.stepAngle', { deg: number(stepDegrees(step), step < 1 ? 1 : 0) })
                  : t('move.stepOf', { mm: number(step, step < 1 ? 1 : 0), deg: number(stepDegrees(step), step < 1 ? 1 : 0) }),
            })),
          ].filter((option, i, all) => all.findIndex((other) => other.name === option.name) === i)}
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
