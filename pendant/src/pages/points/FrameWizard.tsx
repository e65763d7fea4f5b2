/**
 * Teaches a frame from three points that the tool tip touches: its origin, one on x, one on the side of y.
 */
import { useEffect, useState } from 'preact/hooks';
import { number, t } from '../../i18n';
import { problemLine, problemOf } from '../../i18n/told';
import { complain, mayProgram, request, robot } from '../../state/cell';
import { changePoints, distance, frameNames, goodName, values } from '../../state/points';
import { toast } from '../../state/toasts';
import { Button, Field } from '../../ui/controls';
import { Dialog } from '../../ui/Dialog';
import { kDeg, mm, withinSentence } from '../../ui/format';
import { Icon } from '../../ui/Icon';
import type { Pose, Vec3 } from '../../wire/types';
import { freeName } from '../program/edits';
import { PoseTable } from './Detail';
import './points.css';
import { kNoTouches, MoveButton, touches, waiting, Whose } from './teaching';

interface Answer {
  pose: Pose;
  angle: number;
  x_length: number;
  y_length: number;
}
const kSteps = ['points.fOrigin', 'points.fOnX', 'points.fInPlane'] as const;

export function FrameWizard({ onClose }: { onClose: () => void }) {
  const touched = touches.value;
  const [name, setName] = useState(() => freeName('Frame', frameNames.value));
  const [answer, setAnswer] = useState<Answer | null>(null);
  const [problem, setProblem] = useState('');
  const [origin, onX, inPlane] = touched;
  const args = { name, origin, on_x: onX, in_plane: inPlane };
  const whole = !!origin && !!onX && !!inPlane;
  useEffect(() => {
    setAnswer(null);
    setProblem('');
    if (!whole) return;
    let current = true; // an answer for earlier places must not replace the newest one
    request('points.frame', { ...args, dry: true }).then(
      (found) => current && setAnswer(found),
      (error: Error) => current && setProblem(problemLine(problemOf(error))),
    );
    return () => {
      current = false;
    };
  }, [touched]);
  const touch = (i: number) => {
    const mine = touches.mine();
    return request('points.here', { robot: robot.value?.name ?? '' }).then((here) => (mine.value = mine.value.map((old, k) => (k === i ? here.tcp.p : old))), complain);
  };
  const taken = values.value.some((each) => each.name === name);
  const nameProblem = name !== '' && !goodName(name) ? t('points.badName') : taken ? t('points.exists') : '';
  const [saving, setSaving] = useState(false);
  const save = async () => {
    const mine = touches.mine();
    setSaving(true);
    const saved = await changePoints('points.frame', args);
    setSaving(false);
    if (!saved) return;
    onClose();
    [mine.value, waiting.value] = [kNoTouches, null];
    toast({ kind: 'ok', text: t('points.fSaved', { name }) });
  };
  return (
    <Dialog
      title={t('points.frame')}
      onClose={onClose}
      side
      actions={
        <>
          <MoveButton kind="frame" />
          <Button label={t('points.fSave')} icon="save" tone="primary" disabled={saving || !answer || name === '' || nameProblem !== '' || !mayProgram.value} onClick={() => void save()} />
        </>
      }
    >
      <Whose />
      <p>{t('points.fText')}</p>
      <ol class="points-wizard">
        {kSteps.map((step, i) => (
          <li key={step} class={touched[i] ? 'done' : ''}>
            <Icon name={touched[i] ? 'check' : 'pin'} size={22} />
            <span>
              <strong>{t(step)}</strong>
              <small>{touched[i] ? at(touched[i]!) : t('points.notYet')}</small>
            </span>
            <Button label={t(touched[i] ? 'points.again' : 'points.take', { what: withinSentence(t(step)) })} onClick={() => void touch(i)} />
          </li>
        ))}
      </ol>
      {problem && <p class="points-bad" role="alert">{problem}</p>}
      {answer && (
        <section aria-label={t('points.result')}>
          <h3>{t('points.result')}</h3>
          <PoseTable pose={answer.pose} />
          <p class={Math.abs(answer.angle * kDeg - 90) > 45 ? 'points-bad' : 'note'}>
            {t('points.fResidual', { angle: number(answer.angle * kDeg, 1), x: mm(answer.x_length), y: mm(answer.y_length) })}
          </p>
        </section>
      )}
      {origin && onX && distance(origin, onX) < 0.05 && <p class="points-bad">{t('points.fShort')}</p>}
      <Field label={t('points.fName')} value={name} problem={nameProblem} onInput={setName} />
    </Dialog>
  );
}

export const at = (p: Vec3) => `X ${mm(p[0])}  Y ${mm(p[1])}  Z ${mm(p[2])} mm`;
