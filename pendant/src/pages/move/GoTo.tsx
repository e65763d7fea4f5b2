/**
 * Goes to joint values, a pose or a taught point. Shows the way first; the robot moves while the button is
 * held.
 */
import { useEffect, useState } from 'preact/hooks';
import { t } from '../../i18n';
import { request as ask, robot } from '../../state/cell';
import { armOrder } from '../../state/models';
import { valueNow } from '../../state/live';
import { settings } from '../../state/settings';
import { Button, Field, Segmented, Select } from '../../ui/controls';
import { Dialog } from '../../ui/Dialog';
import { angleUnit, jointText, kDeg, kMm, jointTitle } from '../../ui/format';
import { compose, fromRollPitchYaw, rollPitchYaw } from '../../view3d/chain';
import type { JointInfo, Pose, Vec3 } from '../../wire/types';
import { inFrame, tcpPose } from './axes';
import { GoKey, type Goal } from './GoKey';

interface PointValue {
  name: string;
  kind: string;
  world?: Pose | null;
  joints?: Record<string, number> | null;
}
type What = 'joints' | 'pose' | 'point';

const turns = () => (settings.degrees.value ? kDeg : 1);
const factor = (joint: JointInfo) => (joint.unit === 'm' ? kMm : turns());
const written = (value: number, digits: number) => String(Number(value.toFixed(digits)));
const read = (text: string) => (text.trim() === '' ? NaN : Number(text.replace(',', '.').replace('−', '-')));

export function GoTo({ onClose }: { onClose: () => void }) {
  const info = robot.value!;
  const [what, setWhat] = useState<What>('joints');
  const [joints, setJoints] = useState(() => currentJoints());
  const [pose, setPose] = useState(() => currentPose());
  const [points, setPoints] = useState<PointValue[]>([]);
  const [point, setPoint] = useState('');
  useEffect(() => {
    ask('points').then(
      (got) => {
        const able = got.values.filter((each) => each.joints || each.world);
        setPoints(able);
        setPoint(able[0]?.name ?? '');
        if (able.length) setWhat('point');
      },
      () => undefined,
    );
  }, []);

  const goal = goalOf(what, info.joints, joints, pose, points.find((each) => each.name === point));
  return (
    <Dialog title={t('goto.title')} onClose={onClose} side clear>
      <Segmented<What>
        label={t('goto.title')}
        value={what}
        options={[
          { id: 'point', name: t('goto.point') },
          { id: 'joints', name: t('goto.joints') },
          { id: 'pose', name: t('goto.pose') },
        ]}
        onChange={setWhat}
      />
      {what === 'point' && <Points points={points} chosen={point} onChange={setPoint} />}
      {what === 'joints' && <JointFields joints={info.joints} values={joints} onChange={setJoints} />}
      {what === 'pose' && <PoseFields values={pose} onChange={setPose} />}
      {what !== 'point' && (
        <div class="row">
          <Button label={t('goto.here')} onClick={() => (setJoints(currentJoints()), setPose(currentPose()))} />
          {what === 'joints' && <Button label={t('goto.zero')} onClick={() => setJoints(info.joints.map(() => '0'))} />}
        </div>
      )}
      <GoKey goal={goal} />
    </Dialog>
  );
}

function currentJoints(): string[] {
  const info = robot.peek()!;
  return info.joints.map((joint) => written(valueNow(`${joint.interface}/position`) * factor(joint), 2));
}
function currentPose(): string[] {
  const at = inFrame(tcpPose(), robot.peek()!.base);
  const turned = rollPitchYaw(at.q);
  return [...at.p.map((v) => written(v * kMm, 2)), ...turned.map((v) => written(v * turns(), 2))];
}

function goalOf(what: What, infos: JointInfo[], joints: string[], pose: string[], point?: PointValue): Goal | null {
  if (what === 'joints') {
    const values = infos.map((joint, i) => read(joints[i] ?? '') / factor(joint));
    if (values.some((value, i) => !Number.isFinite(value) || outside(infos[i]!, value))) return null;
    return { joints: Object.fromEntries(infos.map((joint, i) => [joint.name, values[i]!])) };
  }
  if (what === 'pose') {
    const values = pose.map((text, i) => read(text) / (i < 3 ? kMm : turns()));
    if (!values.every(Number.isFinite)) return null;
    const inBase = { p: values.slice(0, 3) as Vec3, q: fromRollPitchYaw(values.slice(3) as Vec3) };
    return { pose: compose(robot.peek()!.base, inBase) };
  }
  if (point?.joints) return { joints: point.joints };
  return point?.world ? { pose: point.world } : null;
}

function outside(joint: JointInfo, value: number): boolean {
  return joint.type !== 'continuous' && joint.upper > joint.lower && (value < joint.lower - 1e-9 || value > joint.upper + 1e-9);
}

function Points(props: { points: PointValue[]; chosen: string; onChange: (name: string) => void }) {
  if (props.points.length === 0) return <p class="note">{t('goto.none')}</p>;
  return (
    <Select
      label={t('goto.point')}
      value={props.chosen}
      options={props.points.map((each) => ({ id: each.name, name: each.name }))}
      onChange={props.onChange}
    />
  );
}

function JointFields(props: { joints: JointInfo[]; values: string[]; onChange: (values: string[]) => void }) {
  return (
    <div class="goto-fields">
      {armOrder(robot.value!).map((i) => {
        const joint = props.joints[i]!;
        const value = read(props.values[i] ?? '') / factor(joint);
        const range = t('move.range', { lower: jointText(joint.lower, joint.unit, 0), upper: jointText(joint.upper, joint.unit, 0) });
        const bad = !Number.isFinite(value) ? t('goto.bad') : outside(joint, value) ? t('goto.outside', { range }) : undefined;
        return (
          <Field
            key={joint.name}
            label={jointTitle(joint.name)}
            value={props.values[i] ?? ''}
            unit={joint.unit === 'm' ? 'mm' : angleUnit()}
            problem={bad}
            numeric
            onInput={(text) => props.onChange(props.values.map((old, k) => (k === i ? text : old)))}
          />
        );
      })}
    </div>
  );
}

function PoseFields(props: { values: string[]; onChange: (values: string[]) => void }) {
  return (
    <div class="goto-fields">
      {['X', 'Y', 'Z', 'RX', 'RY', 'RZ'].map((name, i) => (
        <Field
          key={name}
          label={name}
          value={props.values[i] ?? ''}
          unit={i < 3 ? 'mm' : angleUnit()}
          problem={Number.isFinite(read(props.values[i] ?? '')) ? undefined : t('goto.bad')}
          numeric
          onInput={(text) => props.onChange(props.values.map((old, k) => (k === i ? text : old)))}
        />
      ))}
    </div>
  );
}
