/** What the wizards for the payload and for the joints share: both change cell.yaml, which the cell reads when it starts again. */
import { useEffect, useState } from 'preact/hooks';
import { t } from '../../i18n';
import { problemOf, problemWords, type Told } from '../../i18n/told';
import { complain, mayAdminister, mayProgram, request } from '../../state/cell';
import { toast } from '../../state/toasts';
import type { Args, RequestName } from '../../state/cell';
import { Button, Segmented } from '../../ui/controls';
import { Icon } from '../../ui/Icon';
import type { Requests } from '../../wire/requests';
import { restart, restarting } from '../cell/restart';
import { ofRobot } from './samples';

/** Measure, or compare new samples with what the cell has. */
export type Mode = 'measure' | 'check';

/** A result was stored that the running cell does not use yet. */
export const stored = ofRobot(false);

/** The answer to a request that only looks, for the newest arguments; null: nothing is asked. */
export function useDry<Name extends RequestName>(name: Name, args: Args<Name> | null, when: unknown[]): { answer: Requests[Name]['answer'] | null; problem: Told | null } {
  const [answer, setAnswer] = useState<Requests[Name]['answer'] | null>(null);
  const [problem, setProblem] = useState<Told | null>(null);
  useEffect(() => {
    setAnswer(null);
    setProblem(null);
    if (!args) return;
    let current = true; // an answer for earlier samples must not replace the newest one
    request<RequestName>(name, args).then(
      (found) => current && setAnswer(found as Requests[Name]['answer']),
      (error: Error) => current && setProblem(problemWords(problemOf(error))),
    );
    return () => {
      current = false;
    };
  }, when);
  return { answer, problem };
}

/** Why the samples do not determine the result, and what to do. */
export function Refused({ problem }: { problem: Told | null }) {
  if (!problem) return null;
  return (
    <div class="banner" role="alert">
      <div>
        <strong>{problem.text}</strong>
        {[problem.detail, problem.advice].filter(Boolean).map((line) => (
          <p key={line}>{line}</p>
        ))}
      </div>
    </div>
  );
}

export function ModeChoice({ mode, onChange }: { mode: Mode; onChange: (mode: Mode) => void }) {
  return (
    <Segmented<Mode>
      label={t('calibrate.mode')}
      value={mode}
      options={[
        { id: 'measure', name: t('calibrate.measure') },
        { id: 'check', name: t('calibrate.check') },
      ]}
      onChange={onChange}
    />
  );
}

/** A sample that was taken: what is left of it, and a key to leave it out. */
export function Taken({ index, wrong, text, onDrop }: { index: number; wrong: boolean; text: string; onDrop: () => void }) {
  return (
    <li class="done">
      <Icon name={wrong ? 'close' : 'check'} size={22} />
      <span>
        <strong>{t('calibrate.sample', { number: index + 1 })}</strong>
        <small class={wrong ? 'points-bad' : ''}>{text}</small>
      </span>
      <Button label={t('calibrate.drop', { number: index + 1 })} icon="trash" bare onClick={onDrop} />
    </li>
  );
}

/** Takes back the last calibration that was stored. */
export async function takeBack(): Promise<void> {
  const mine = stored.mine();
  try {
    const { key, robot } = await request('calibrate.undo');
    mine.value = true;
    toast({ kind: 'ok', text: t(key === 'payload' ? 'calibrate.undonePayload' : 'calibrate.undoneJoints', { robot }) });
  } catch (error) {
    complain(error);
  }
}

/** What to do with what was stored: while the cell does not use it yet, and when it is checked. */
export function AfterStoring({ mode }: { mode: Mode }) {
  const waits = stored.value;
  if (!waits && mode !== 'check') return null;
  const mine = stored.mine();
  const go = async () => {
    if (await restart(t('cell.starting'), t('cell.started'), 'cell.reset', {})) mine.value = false;
  };
  const undo = <Button label={t('calibrate.undo')} icon="undo" disabled={!mayProgram.value || restarting.value !== ''} onClick={() => void takeBack()} />;
  if (!waits) return <div class="row">{undo}</div>;
  return (
    <div class="banner points-after" role="status">
      <p>{t('calibrate.later')}</p>
      <div class="row">
        <Button label={t('calibrate.startAgain')} icon="repeat" tone="primary" disabled={!mayAdminister.value || restarting.value !== ''} onClick={() => void go()} />
        {undo}
      </div>
    </div>
  );
}
