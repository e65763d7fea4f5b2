/** Going to joint values, a pose or a taught point: shown first, then gone to as long as the button is held. */
import { useEffect, useMemo, useState } from 'preact/hooks';
import { t } from '../../i18n';
import { request as ask, robot } from '../../state/cell';
import { heldKey, pressFollow, release } from '../../state/jog';
import { beat, valueNow } from '../../state/live';
import { chain, jointValues } from '../../state/models';
import { settings } from '../../state/settings';
import { Button, Field, Segmented, Select } from '../../ui/controls';
import { Dialog } from '../../ui/Dialog';
import { angleUnit, jointText, kDeg, kMm } from '../../ui/format';
import { compose, fromRollPitchYaw, inverse, rollPitchYaw } from '../../view3d/chain';
import { preview } from '../../view3d/RobotView';
import type { Json } from '../../wire/connection';
import type { JointInfo, Pose, Vec3 } from '../../wire/types';
import { inFrame, jointTitle, tcpPose } from './axes';
import { HoldButton } from './JogKeys';

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
  const [line, setLine] = useState(false);
  const [joints, setJoints] = useState(() => currentJoints());
  const [pose, setPose] = useState(() => currentPose());
  const [points, setPoints] = useState<PointValue[]>([]);
  const [point, setPoint] = useState('');
  useEffect(() => {
    ask<{ values: PointValue[] }>('points').then(
      (got) => {
        const able = got.values.filter((each) => each.joints || each.world);
        setPoints(able);
        setPoint(able[0]?.name ?? '');
        if (able.length) setWhat('point');
      },
      () => undefined,
    );
    return () => {
      release();
      preview.value = null;
    };
  }, []);

  const goal = goalOf(what, info.joints, joints, pose, points.find((each) => each.name === point));
  const key = JSON.stringify([goal, line]);
  const plan = useMemo(() => (goal ? planTo(goal, line) : null), [key]);
  useEffect(() => {
    preview.value = plan ? { robot: info.name, path: plan.path, joints: plan.joints } : null;
  }, [plan]);
  const request = goal && plan?.joints ? requestOf(goal, plan.joints, line) : null;
  const moving = heldKey.value === 'goto';
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
      <Segmented
        label={t('goto.way')}
        value={line ? 'line' : 'joint'}
        options={[
          { id: 'joint', name: t('goto.wayJoint') },
          { id: 'line', name: t('goto.wayLine') },
        ]}
        onChange={(way) => setLine(way === 'line')}
      />
      {goal && !plan?.joints && <p class="problem-text">{t('goto.unreachable')}</p>}
      {goal && plan?.joints && <p class="note">{t(arrived(plan.joints) ? 'goto.arrived' : 'goto.preview')}</p>}
      <HoldButton
        class="goto-hold"
        label={t(moving ? 'goto.moving' : 'goto.move')}
        held={moving}
        disabled={!request}
        onPress={() => request && pressFollow(request)}
        onRelease={release}
      >
        {t(moving ? 'goto.moving' : 'goto.move')}
      </HoldButton>
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

type Goal = { joints: Record<string, number> } | { pose: Pose };

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

const kPoints = 40;

/** Where the robot will stand, and the way of its TCP in the world; no joints where it does not get there. */
function planTo(goal: Goal, line: boolean): { path: Vec3[]; joints: Record<string, number> | null } {
  const arm = chain.peek();
  const info = robot.peek()!;
  if (!arm) return { path: [], joints: null };
  const now = jointValues(info.name);
  const { base } = info;
  const inWorld = (at: Pose) => compose(base, at).p;
  const joints = 'joints' in goal ? goal.joints : arm.solveFor(compose(inverse(base), goal.pose), now);
  if (!joints) return { path: [], joints: null };
  const ends = [arm.solve(now).tcp, arm.solve((name) => joints[name] ?? 0).tcp].map(inWorld);
  const path = Array.from({ length: kPoints }, (_, i): Vec3 => {
    const share = i / (kPoints - 1);
    if (line) return ends[0]!.map((v, k) => v + share * (ends[1]![k]! - v)) as Vec3;
    const between = (name: string) => (now(name) || 0) + share * ((joints[name] ?? 0) - (now(name) || 0));
    return inWorld(arm.solve(between).tcp);
  });
  return { path, joints };
}

/** A line goes to the pose, anything else to the joints that the picture shows. */
function requestOf(goal: Goal, joints: Record<string, number>, line: boolean): Json {
  const info = robot.peek()!;
  if (!line) return { joints: Object.fromEntries(info.joints.map((joint) => [joint.interface.slice(info.name.length + 1), joints[joint.name] ?? 0])) };
  const { base } = info;
  const pose = 'pose' in goal ? goal.pose : compose(base, chain.peek()!.solve((name) => joints[name] ?? 0).tcp);
  return { pose: { position: pose.p, orientation: pose.q }, frame: 'world' };
}

function arrived(joints: Record<string, number>): boolean {
  beat.value;
  return robot.peek()!.joints.every((joint) => {
    const way = Math.abs(valueNow(`${joint.interface}/position`) - (joints[joint.name] ?? NaN));
    return !(way > 2e-3) || joint.moves_tcp === false;
  });
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
      {props.joints.map((joint, i) => {
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
