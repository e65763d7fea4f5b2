/**
 * Teaches the TCP of a tool whose tip touches one place from four or more directions. Shows the remaining
 * error.
 */
import { useEffect, useState } from 'preact/hooks';
import { number, t } from '../../i18n';
import { problemLine, problemOf } from '../../i18n/told';
import { complain, mayProgram, request, robot } from '../../state/cell';
import { changePoints, goodName, values } from '../../state/points';
import { toast } from '../../state/toasts';
import { Button, Field } from '../../ui/controls';
import { Dialog } from '../../ui/Dialog';
import { kDeg, mm } from '../../ui/format';
import { Icon } from '../../ui/Icon';
import type { PointsToolAnswer } from '../../wire/requests';
import { freeName } from '../program/edits';
import { at } from './FrameWizard';
import { MoveButton, toolPoses, waiting, Whose } from './teaching';

const kLeast = 4;
/** m; above this error the poses did not touch the same place. */
const kGood = 0.001;

export function ToolWizard({ onClose }: { onClose: () => void }) {
  const poses = toolPoses.value;
  const [name, setName] = useState(() => freeName('Tool', values.value.map((each) => each.name)));
  const [answer, setAnswer] = useState<PointsToolAnswer | null>(null);
  const [problem, setProblem] = useState('');
  useEffect(() => {
    setAnswer(null);
    setProblem('');
    if (poses.length < kLeast) return;
    let current = true; // an answer for earlier poses must not replace the newest one
    request('points.tool', { name, poses, dry: true }).then(
      (found) => current && setAnswer(found),
      (error: Error) => current && setProblem(problemLine(problemOf(error))),
    );
    return () => {
      current = false;
    };
  }, [poses]);
  const touch = () => {
    const mine = toolPoses.mine();
    return request('points.here', { robot: robot.value?.name ?? '' }).then((here) => (mine.value = [...mine.value, here.flange]), complain);
  };
  const taken = values.value.some((each) => each.name === name);
  const nameProblem = name !== '' && !goodName(name) ? t('points.badName') : taken ? t('points.exists') : '';
  const [saving, setSaving] = useState(false);
  const save = async () => {
    const mine = toolPoses.mine();
    setSaving(true);
    const saved = await changePoints('points.tool', { name, poses });
    setSaving(false);
    if (!saved) return;
    onClose();
    [mine.value, waiting.value] = [[], null];
    toast({ kind: 'ok', text: t('points.tSaved', { name }) });
  };
  const rows = Math.max(kLeast, poses.length + 1);
  return (
    <Dialog
      title={t('points.tool')}
      onClose={onClose}
      side
      actions={
        <>
          <MoveButton kind="tool" />
          <Button label={t('points.take', { what: t('points.tPose', { number: poses.length + 1 }) })} icon="pin" tone={poses.length < kLeast ? 'primary' : 'plain'} onClick={() => void touch()} />
          <Button label={t('points.tSave')} icon="save" tone="primary" disabled={saving || !answer || answer.largest > kGood || name === '' || nameProblem !== '' || !mayProgram.value} onClick={() => void save()} />
        </>
      }
    >
      <Whose />
      <p>{t('points.tText')}</p>
      <ol class="points-wizard">
        {Array.from({ length: rows }, (_, i) => {
          const left = answer?.residuals[i];
          return (
            <li key={i} class={poses[i] ? 'done' : ''}>
              <Icon name={poses[i] ? 'check' : 'pin'} size={22} />
              <span>
                <strong>{t('points.tPose', { number: i + 1 })}</strong>
                <small class={left !== undefined && left > kGood ? 'points-bad' : ''}>
                  {poses[i] ? (left === undefined ? at(poses[i]!.p) : t('points.tLeft', { mm: mm(left, 2) })) : t('points.notYet')}
                </small>
              </span>
              {poses[i] && <Button label={t('points.tDrop', { number: i + 1 })} icon="trash" bare onClick={() => (toolPoses.value = poses.filter((_, k) => k !== i))} />}
            </li>
          );
        })}
      </ol>
      {problem && <p class="points-bad" role="alert">{problem}</p>}
      {answer && (
        <section aria-label={t('points.result')}>
          <h3>{t('points.result')}</h3>
          <p>
            {t('points.tTcp')}: {at(answer.tcp)}
          </p>
          <p class={answer.largest > kGood ? 'points-bad' : 'note'}>
            {t('points.tResidual', { rms: mm(answer.rms, 2), largest: mm(answer.largest, 2) })}
            {answer.largest > kGood && ` ${t('points.tTooMuch')}`}
          </p>
          <p class="note">{t('points.tSigma', { mm: mm(answer.sigma, 2) })}</p>
          {answer.outlier !== undefined && <p class="points-bad">{t('points.outlier', { number: answer.outlier + 1 })}</p>}
          <p class="note">{t('points.next', { at: at(answer.next.p), rpy: answer.next.rpy.map((each) => number(each * kDeg, 0)).join('  '), now: mm(answer.sigma, 2), then: mm(answer.next_sigma, 2) })}</p>
        </section>
      )}
      <Field label={t('points.tName')} value={name} problem={nameProblem} onInput={setName} />
    </Dialog>
  );
}
