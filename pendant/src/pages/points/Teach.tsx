/** Teaches a new point at the robot's present position. */
import { signal } from '@preact/signals';
import { useState } from 'preact/hooks';
import { t } from '../../i18n';
import { able } from '../../state/abilities';
import { cell, complain, mayProgram, robot, robotName } from '../../state/cell';
import { frameNames, goodName, names, teach, values } from '../../state/points';
import { kept } from '../../state/settings';
import { toast } from '../../state/toasts';
import { Button, Field, Segmented, Select } from '../../ui/controls';
import { freeName } from '../program/edits';
import { chosen } from './choice';

const kind = kept<'pose' | 'joints'>('points.kind', 'pose');
const frame = kept<string>('points.frame', '');
const group = signal('');
const more = signal(false);

export function Teach() {
  const [wanted, setWanted] = useState<string | null>(null);
  const taken = [...values.value, ...names.value].map((each) => each.name);
  const name = wanted ?? freeName('P', taken);
  const problem = name === '' ? '' : !goodName(name) ? t('points.badName') : taken.includes(name) ? t('points.exists') : '';
  const go = async () => {
    if (name === '' || problem) return;
    const inFrame = kind.value === 'pose' && frameNames.value.includes(frame.value) ? frame.value : undefined;
    try {
      await teach({ name, robot: robot.value?.name ?? '', kind: kind.value, frame: inFrame, group: group.value || undefined });
      toast({ kind: 'ok', text: t('points.taught', { name }) });
      chosen.value = [name];
      setWanted(null);
    } catch (error) {
      complain(error);
    }
  };
  const robots = cell.value?.robots ?? [];
  return (
    <section class="points-teach" aria-label={t('points.teachTitle')}>
      <Field label={t('points.newName')} value={name} problem={problem} onInput={setWanted} onEnter={() => void go()} />
      <Button label={t('points.teach')} icon="pin" tone="good" big disabled={!mayProgram.value || name === '' || problem !== ''} onClick={() => void go()} />
      <Button label={t('points.more')} icon="settings" bare pressed={more.value} onClick={() => (more.value = !more.value)} />
      {robots.length > 1 && (
        <Segmented label={t('move.robot')} value={robot.value?.name ?? ''} options={robots.map((each) => ({ id: each.name, name: each.name }))} onChange={(id) => (robotName.value = id)} />
      )}
      {more.value && (
        <div class="points-more">
          <Segmented
            label={t('points.kind')}
            value={kind.value}
            options={[
              { id: 'pose', name: t('points.asPose'), title: t('points.asPoseWhy') },
              { id: 'joints', name: t('points.asJoints'), title: t('points.asJointsWhy') },
            ]}
            onChange={(id) => (kind.value = id)}
          />
          {kind.value === 'pose' && (
            <Select
              label={t('points.inFrame')}
              value={frameNames.value.includes(frame.value) ? frame.value : ''}
              options={[{ id: '', name: t('points.world') }, ...frameNames.value.map((id) => ({ id, name: id }))]}
              onChange={(id) => (frame.value = id)}
            />
          )}
          {able('points.group') && <Field label={t('points.group')} value={group.value} placeholder={t('points.noGroup')} onInput={(text) => (group.value = text)} />}
        </div>
      )}
    </section>
  );
}
