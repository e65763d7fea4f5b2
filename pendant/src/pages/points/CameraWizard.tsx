/**
 * Teaches where a camera is, on the hand or beside the robot, from a marker that it sees while the robot moves. The pose of
 * the marker is a value of the cell's data, which a link, a file or a program writes. Shows what is left of each sighting.
 */
import { useEffect, useState } from 'preact/hooks';
import { number, t } from '../../i18n';
import { problemLine, problemOf } from '../../i18n/told';
import { complain, mayProgram, request, robot } from '../../state/cell';
import { changePoints, goodName, values } from '../../state/points';
import { toast } from '../../state/toasts';
import { Button, Field, Segmented, Select } from '../../ui/controls';
import { Dialog } from '../../ui/Dialog';
import { kDeg, mm } from '../../ui/format';
import { Icon } from '../../ui/Icon';
import type { PointsCameraAnswer } from '../../wire/requests';
import { freeName } from '../program/edits';
import { at } from './FrameWizard';
import { MoveButton, sightings, waiting, Whose } from './teaching';

const kLeast = 3;
/** s; a marker that has not changed for longer may be the one of an earlier pose. */
const kOld = 5;

/** The choices of the wizard; kept while the user moves the robot. */
const kept: { place: 'hand' | 'beside'; marker: string } = { place: 'hand', marker: '' };

export function CameraWizard({ onClose }: { onClose: () => void }) {
  const taken = sightings.value;
  const markers = values.value.filter((each) => each.kind === 'pose').map((each) => each.name);
  const [place, setPlace] = useState(kept.place);
  const [marker, setMarker] = useState(kept.marker || (markers[0] ?? ''));
  const [name, setName] = useState(() => freeName('Camera', values.value.map((each) => each.name)));
  const [answer, setAnswer] = useState<PointsCameraAnswer | null>(null);
  const [problem, setProblem] = useState('');
  const [old, setOld] = useState(0);
  [kept.place, kept.marker] = [place, marker];
  const args = { name, sightings: taken, place, robot: robot.value?.name ?? '' };
  useEffect(() => {
    setAnswer(null);
    setProblem('');
    if (taken.length < kLeast) return;
    let current = true; // an answer for earlier sightings must not replace the newest one
    request('points.camera', { ...args, dry: true }).then(
      (found) => current && setAnswer(found),
      (error: Error) => current && setProblem(problemLine(problemOf(error))),
    );
    return () => {
      current = false;
    };
  }, [taken, place, args.robot]);
  const take = () => {
    const mine = sightings.mine();
    return request('points.sighting', { marker, robot: robot.value?.name ?? '' }).then((seen) => {
      setOld(seen.age > kOld ? seen.age : 0);
      mine.value = [...mine.value, { flange: seen.flange, marker: seen.marker }];
    }, complain);
  };
  const exists = values.value.some((each) => each.name === name);
  const nameProblem = name !== '' && !goodName(name) ? t('points.badName') : exists ? t('points.exists') : '';
  const [saving, setSaving] = useState(false);
  const save = async () => {
    const mine = sightings.mine();
    setSaving(true);
    const saved = await changePoints('points.camera', args);
    setSaving(false);
    if (!saved) return;
    onClose();
    [mine.value, waiting.value] = [[], null];
    toast({ kind: 'ok', text: t('points.cSaved', { name }) });
  };
  return (
    <Dialog
      title={t('points.camera')}
      onClose={onClose}
      side
      actions={
        <>
          <MoveButton kind="camera" />
          <Button label={t('points.cTake', { number: taken.length + 1 })} icon="eye" tone={taken.length < kLeast ? 'primary' : 'plain'} disabled={marker === ''} onClick={() => void take()} />
          <Button label={t('points.cSave')} icon="save" tone="primary" disabled={saving || !answer || answer.outlier !== undefined || name === '' || nameProblem !== '' || !mayProgram.value} onClick={() => void save()} />
        </>
      }
    >
      <Whose />
      <p>{t('points.cText')}</p>
      <Segmented
        label={t('points.cPlace')}
        value={place}
        options={[
          { id: 'hand', name: t('points.cHand') },
          { id: 'beside', name: t('points.cBeside') },
        ]}
        onChange={setPlace}
      />
      <Select label={t('points.cMarker')} value={marker} options={markers.map((each) => ({ id: each, name: each }))} onChange={setMarker} />
      {markers.length === 0 && <p class="points-bad">{t('points.cNoMarker')}</p>}
      {old > 0 && <p class="points-bad" role="status">{t('points.cOld', { seconds: number(old, 0) })}</p>}
      <ol class="points-wizard">
        {taken.map((each, i) => (
          <li key={i} class="done">
            <Icon name={answer?.outlier === i ? 'close' : 'check'} size={22} />
            <span>
              <strong>{t('points.cSighting', { number: i + 1 })}</strong>
              <small class={answer?.outlier === i ? 'points-bad' : ''}>
                {answer?.position_residuals[i] === undefined
                  ? at(each.flange.p)
                  : t('points.cLeft', { mm: mm(answer.position_residuals[i]!, 2), degrees: number(answer.rotation_residuals[i]! * kDeg, 2) })}
              </small>
            </span>
            <Button label={t('points.cDrop', { number: i + 1 })} icon="trash" bare onClick={() => (sightings.value = taken.filter((_, k) => k !== i))} />
          </li>
        ))}
      </ol>
      {problem && <p class="points-bad" role="alert">{problem}</p>}
      {answer && (
        <section aria-label={t('points.result')}>
          <h3>{t('points.result')}</h3>
          <p>
            {t(place === 'hand' ? 'points.cOnHand' : 'points.cInWorld')}: {at(answer.camera.p)}
          </p>
          <p class="note">{t('points.cSigma', { mm: mm(answer.position_sigma, 2), degrees: number(answer.rotation_sigma * kDeg, 3) })}</p>
          {answer.outlier !== undefined && <p class="points-bad">{t('points.outlier', { number: answer.outlier + 1 })}</p>}
          <p class="note">{t('points.next', { at: at(answer.next.p), rpy: answer.next.rpy.map((each) => number(each * kDeg, 0)).join('  '), now: mm(answer.position_sigma, 2), then: mm(answer.next_sigma, 2) })}</p>
        </section>
      )}
      <Field label={t('points.cName')} value={name} problem={nameProblem} onInput={setName} />
    </Dialog>
  );
}
