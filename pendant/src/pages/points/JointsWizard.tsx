/**
 * Finds the joint offsets of an arm from poses of a target on its hand that a measuring device sees: a laser tracker, a camera.
 * Its pose is a value of the cell's data, which a link, a file or a program writes.
 */
import { useState } from 'preact/hooks';
import { number, t } from '../../i18n';
import { complain, mayProgram, request, robot } from '../../state/cell';
import { values } from '../../state/points';
import { toast } from '../../state/toasts';
import { Button, Segmented, Select, Toggle } from '../../ui/controls';
import { Dialog } from '../../ui/Dialog';
import { jointText, jointTitle, kDeg, mm } from '../../ui/format';
import { AfterStoring, type Mode, ModeChoice, Refused, stored, Taken, useDry } from './calibrating';
import { hardlyTurned } from './directions';
import { at } from './FrameWizard';
import './points.css';
import { armPoses, MoveButton, waiting, Whose } from './teaching';
import type { CalibrateJointsAnswer } from '../../wire/requests';

const kLeast = { measure: 4, check: 3 };
/** Poses from which the result is good. */
const kGood = 30;
/** s; a value that has not changed for longer may be the one of an earlier pose. */
const kOld = 5;
/** rad; a joint shows its offset if it has turned by more. */
const kSpan = 1;

/** The choices of the wizard; kept while the user moves the robot. */
const kept: { mode: Mode; marker: string; sees: 'poses' | 'positions'; inBase: boolean; ofFlange: boolean } = { mode: 'measure', marker: '', sees: 'poses', inBase: false, ofFlange: false };

export function JointsWizard({ onClose }: { onClose: () => void }) {
  const taken = armPoses.value;
  const markers = values.value.filter((each) => each.kind === 'pose').map((each) => each.name);
  const [how, setHow] = useState({ ...kept, marker: kept.marker || (markers[0] ?? '') });
  const change = (next: Partial<typeof kept>) => setHow({ ...how, ...next });
  const [old, setOld] = useState(0);
  const [saving, setSaving] = useState(false);
  Object.assign(kept, how);
  const { mode, marker, sees, inBase, ofFlange } = how;
  const name = robot.value?.name ?? '';
  const args = { robot: name, samples: taken, positions: sees === 'positions', in_base: inBase, of_flange: ofFlange };
  const enough = taken.length >= kLeast[mode];
  const { answer, problem } = useDry('calibrate.joints', enough ? { ...args, dry: true, check: mode === 'check' } : null, [taken, mode, sees, inBase, ofFlange, name, stored.value]);
  const take = () => {
    const mine = armPoses.mine();
    return request('calibrate.sample', { robot: name, marker }).then(({ joints, measured, age }) => {
      setOld((age ?? 0) > kOld ? age! : 0);
      if (measured) mine.value = [...mine.value, { joints, measured }];
    }, complain);
  };
  const save = async () => {
    const [mine, after] = [armPoses.mine(), stored.mine()];
    setSaving(true);
    try {
      await request('calibrate.joints', args);
      [mine.value, after.value, waiting.value] = [[], true, null];
      change({ mode: 'check' });
      toast({ kind: 'ok', text: t('calibrate.jSaved', { robot: name }) });
    } catch (error) {
      complain(error);
    } finally {
      setSaving(false);
    }
  };
  const still = mode === 'measure' && taken.length >= 2 ? hardlyTurned(taken.map((each) => each.joints), kSpan, robot.value?.joints ?? []) : [];
  const left = (i: number) => {
    const value = answer?.position_residuals[i];
    if (value === undefined) return at(taken[i]!.measured.p);
    const off = t('calibrate.off', { value: mm(value, 2), unit: 'mm' });
    return sees === 'positions' ? off : t('points.cLeft', { mm: mm(value, 2), degrees: number(answer!.rotation_residuals[i]! * kDeg, 2) });
  };
  return (
    <Dialog
      title={t('calibrate.joints')}
      onClose={onClose}
      side
      actions={
        <>
          <MoveButton kind="joints" />
          <Button label={t('calibrate.take', { number: taken.length + 1 })} icon="pin" tone={enough ? 'plain' : 'primary'} disabled={marker === ''} onClick={() => void take()} />
          {mode === 'measure' && (
            <Button label={t('calibrate.jSave')} icon="save" tone="primary" disabled={saving || !answer || answer.outlier !== undefined || !mayProgram.value} onClick={() => void save()} />
          )}
        </>
      }
    >
      <Whose />
      <AfterStoring mode={mode} />
      <ModeChoice mode={mode} onChange={(next) => change({ mode: next })} />
      <p>{t(mode === 'measure' ? 'calibrate.jText' : 'calibrate.jCheckText', { count: kGood })}</p>
      <details class="points-how" open={taken.length === 0}>
        <summary>{t('calibrate.jHow')}</summary>
        <div>
          <Select label={t('calibrate.jMarker')} value={marker} options={markers.map((each) => ({ id: each, name: each }))} onChange={(next) => change({ marker: next })} />
          {markers.length === 0 && <p class="points-bad">{t('calibrate.jNoMarker')}</p>}
          <Segmented
            label={t('calibrate.jSees')}
            value={sees}
            options={[
              { id: 'poses', name: t('calibrate.jPoses') },
              { id: 'positions', name: t('calibrate.jPositions') },
            ]}
            onChange={(next) => change({ sees: next })}
          />
          <Toggle label={t('calibrate.jInBase')} value={inBase} onChange={(on) => change({ inBase: on })} />
          <Toggle label={t('calibrate.jOfFlange')} value={ofFlange} onChange={(on) => change({ ofFlange: on })} />
        </div>
      </details>
      {old > 0 && <p class="points-bad" role="status">{t('calibrate.jOld', { seconds: number(old, 0) })}</p>}
      <p role="status">{t('calibrate.jCount', { count: taken.length, of: mode === 'measure' ? kGood : kLeast.check })}</p>
      {still.length > 0 && <p class="note">{t('calibrate.jStill', { joints: still.map(jointTitle).join(', ') })}</p>}
      <Refused problem={problem} />
      {answer && <Result answer={answer} mode={mode} />}
      <ol class="points-wizard">
        {taken.map((_, i) => (
          <Taken key={i} index={i} wrong={answer?.outlier === i} text={left(i)} onDrop={() => (armPoses.value = taken.filter((__, k) => k !== i))} />
        ))}
      </ol>
    </Dialog>
  );
}

function Result({ answer, mode }: { answer: CalibrateJointsAnswer; mode: Mode }) {
  const unit = (joint: string) => robot.value?.joints.find((each) => each.name === joint)?.unit ?? 'rad';
  return (
    <section aria-label={t('points.result')}>
      <h3>{t('points.result')}</h3>
      {mode === 'measure' && (
        <table class="plain">
          <thead>
            <tr>
              <th>{t('cell.joint')}</th>
              <th>{t('calibrate.jOffset')}</th>
              <th>{t('calibrate.jSigma')}</th>
            </tr>
          </thead>
          <tbody>
            {answer.joints.map((each) => (
              <tr key={each.joint}>
                <td>{jointTitle(each.joint)}</td>
                {each.identifiable ? (
                  <>
                    <td>{jointText(each.offset, unit(each.joint), 3)}</td>
                    <td>± {jointText(each.sigma, unit(each.joint), 3)}</td>
                  </>
                ) : (
                  <td colSpan={2}>{t('calibrate.jHidden')}</td>
                )}
              </tr>
            ))}
          </tbody>
        </table>
      )}
      <p>
        {mode === 'measure'
          ? t('calibrate.jLeft', { before: mm(answer.position_before, 2), now: mm(answer.position_rms, 2) })
          : t('calibrate.jCheckLeft', { mm: mm(answer.position_rms, 2), degrees: number(answer.rotation_rms * kDeg, 3) })}
      </p>
      {mode === 'measure' && <p class="note">{t('calibrate.jShift', { mm: mm(answer.shift, 2), degrees: number(answer.turn * kDeg, 3) })}</p>}
      {answer.outlier !== undefined && <p class="points-bad">{t('points.outlier', { number: answer.outlier + 1 })}</p>}
    </section>
  );
}
