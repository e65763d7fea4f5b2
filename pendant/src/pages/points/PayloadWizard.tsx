/**
 * Weighs what the hand carries, from forces at the wrist or joint torques in several poses at rest. Shows what is left of each
 * sample, and compares new samples with what the cell has.
 */
import { useState } from 'preact/hooks';
import { number, t } from '../../i18n';
import { complain, mayProgram, request, robot } from '../../state/cell';
import { toast } from '../../state/toasts';
import { Button } from '../../ui/controls';
import { Dialog } from '../../ui/Dialog';
import { mm } from '../../ui/format';
import { Icon } from '../../ui/Icon';
import { AfterStoring, type Mode, ModeChoice, Refused, stored, Taken, useDry } from './calibrating';
import { pointing } from './directions';
import './points.css';
import { MoveButton, waiting, weighings, Whose } from './teaching';

/** The poses that show everything, in words. More poses lower the uncertainty. */
const kPoses = ['calibrate.pDown', 'calibrate.pSide', 'calibrate.pTurned', 'calibrate.pForward', 'calibrate.pAny', 'calibrate.pAny'] as const;
const kLeast = { measure: 3, check: 2 };
const kGravity = 9.81;

const kept: { mode: Mode } = { mode: 'measure' };

export function PayloadWizard({ onClose }: { onClose: () => void }) {
  const taken = weighings.value;
  const [mode, setMode] = useState<Mode>(kept.mode);
  const [busy, setBusy] = useState(false);
  const [saving, setSaving] = useState(false);
  kept.mode = mode;
  const name = robot.value?.name ?? '';
  const args = { robot: name, samples: taken };
  const enough = taken.length >= kLeast[mode];
  const { answer, problem } = useDry('calibrate.payload', enough ? { ...args, dry: true, check: mode === 'check' } : null, [taken, mode, name, stored.value]);
  const take = async () => {
    const mine = weighings.mine();
    setBusy(true);
    try {
      const felt = await request('calibrate.sample', { robot: name, forces: true });
      mine.value = [...mine.value, felt];
    } catch (error) {
      complain(error);
    } finally {
      setBusy(false);
    }
  };
  const save = async () => {
    const [mine, after] = [weighings.mine(), stored.mine()];
    setSaving(true);
    try {
      await request('calibrate.payload', args);
      [mine.value, after.value, waiting.value] = [[], true, null];
      setMode('check');
      toast({ kind: 'ok', text: t('calibrate.pSaved', { robot: name }) });
    } catch (error) {
      complain(error);
    } finally {
      setSaving(false);
    }
  };
  const hints = mode === 'measure' ? kPoses.slice(taken.length) : [];
  const left = (i: number) => {
    const value = answer?.residuals[i];
    const where = pointing(taken[i]!.flange.q);
    return value === undefined ? where : `${where} · ${t('calibrate.off', { value: number(value, 2), unit: answer!.unit })}`;
  };
  return (
    <Dialog
      title={t('calibrate.payload')}
      onClose={onClose}
      side
      actions={
        <>
          <MoveButton kind="payload" />
          <Button label={t(busy ? 'calibrate.weighing' : 'calibrate.take', { number: taken.length + 1 })} icon="pin" tone={enough ? 'plain' : 'primary'} disabled={busy} onClick={() => void take()} />
          {mode === 'measure' && (
            <Button label={t('calibrate.pSave')} icon="save" tone="primary" disabled={saving || !answer || answer.outlier !== undefined || !mayProgram.value} onClick={() => void save()} />
          )}
        </>
      }
    >
      <Whose />
      <AfterStoring mode={mode} />
      <ModeChoice mode={mode} onChange={setMode} />
      <p>{t(mode === 'measure' ? 'calibrate.pText' : 'calibrate.pCheckText')}</p>
      <Refused problem={problem} />
      {answer && (
        <section aria-label={t('points.result')}>
          <h3>{t('points.result')}</h3>
          {mode === 'measure' ? (
            <>
              <p>{t('calibrate.pMass', { mass: number(answer.mass, 3), sigma: number(answer.mass_sigma, 3) })}</p>
              <p>{t('calibrate.pCenter', { x: mm(answer.center[0]), y: mm(answer.center[1]), z: mm(answer.center[2]), sigma: mm(answer.center_sigma) })}</p>
              {answer.tool_mass > 0 && <p class="note">{t('calibrate.pTool', { mass: number(answer.tool_mass, 3) })}</p>}
            </>
          ) : (
            <p>{t('calibrate.pNow', { mass: number(answer.mass, 3), tool: number(answer.tool_mass, 3) })}</p>
          )}
          <p class="note">
            {answer.unit === 'N' ? t('calibrate.pLeft', { rms: number(answer.rms, 2), kg: number(answer.rms / kGravity, 3) }) : t('calibrate.pLeftTorque', { rms: number(answer.rms, 2) })}
          </p>
          {answer.outlier !== undefined && <p class="points-bad">{t('points.outlier', { number: answer.outlier + 1 })}</p>}
        </section>
      )}
      <ol class="points-wizard">
        {taken.map((_, i) => (
          <Taken key={i} index={i} wrong={answer?.outlier === i} text={left(i)} onDrop={() => (weighings.value = taken.filter((__, k) => k !== i))} />
        ))}
        {hints.map((hint, i) => (
          <li key={`hint${i}`}>
            <Icon name="pin" size={22} />
            <span>
              <strong>{t('calibrate.sample', { number: taken.length + i + 1 })}</strong>
              <small>{t(hint)}</small>
            </span>
          </li>
        ))}
      </ol>
    </Dialog>
  );
}
