/**
 * Control of the cell: the button that shows who has it, the dialog to take or release it, and the question
 * when another client asks for it.
 */
import { useEffect, useState } from 'preact/hooks';
import { t, word } from '../i18n';
import { answerQuestion, asked, connected, holder, mayAs, mayTake, releaseControl, role, takeControl, waiting, youHold } from '../state/cell';
import { settings } from '../state/settings';
import { open } from '../ui/ask';
import { Button, Field } from '../ui/controls';
import { Dialog } from '../ui/Dialog';
import { Icon } from '../ui/Icon';

function words(): string {
  if (youHold.value) return t('control.you');
  if (holder.value) return t('control.other', { name: holder.value.name || t('control.someone') });
  return t('control.free');
}

const askedWords = (name: string, seconds: number) => t('control.asking', { name: name || t('control.someone'), seconds });

function shortWords(): string {
  if (waiting.value) return t('control.askingShort');
  return t(youHold.value ? 'control.youShort' : holder.value || !mayTake.value ? 'control.otherShort' : 'control.freeShort');
}

export function ControlButton() {
  if (!connected.value) return null;
  return (
    <button
      type="button"
      class={`control-button ${youHold.value ? 'yours' : ''}`}
      aria-haspopup="dialog"
      aria-label={`${shortWords()}: ${words()}`}
      title={words()}
      onClick={() => open((close) => <ControlDialog onClose={close} />)}
    >
      <Icon name={youHold.value ? 'hand' : waiting.value ? 'clock' : 'eye'} size={20} />
      <span>{shortWords()}</span>
    </button>
  );
}

/**
 * A strip on pages that change something: says that this page has no control, and how to take it; or that its
 * role is too low for what the page changes.
 */
export function WatchOnly({ needs = 'operate' }: { needs?: 'operate' | 'program' | 'administer' }) {
  if (!connected.value) return null;
  if (!mayTake.value) return <Role title={t('control.roleWatch')} />;
  if (!youHold.value) return <Watching />;
  return mayAs(needs) ? null : <Role title={t('control.roleLow', { role: word('role', role.value), needed: word('role', needs) })} />;
}

function Role({ title }: { title: string }) {
  return (
    <div class="banner" role="status">
      <Icon name="eye" />
      <div>
        <strong>{title}</strong>
        <p>{t('control.roleMore')}</p>
      </div>
    </div>
  );
}

function Watching() {
  const wait = waiting.value;
  const left = useSecondsLeft(wait?.until ?? null);
  return (
    <div class="banner" role="status">
      <Icon name={wait ? 'clock' : 'eye'} />
      <div>
        <strong>{words()}</strong>
        {wait && <p>{askedWords(wait.name, left)}</p>}
      </div>
      <Button label={t('control.take')} tone="primary" onClick={() => void takeControl(false)} disabled={waiting.value !== null} />
    </div>
  );
}

function ControlDialog({ onClose }: { onClose: () => void }) {
  const wait = waiting.value;
  const left = useSecondsLeft(wait?.until ?? null);
  return (
    <Dialog
      title={t('control.dialog')}
      onClose={onClose}
      actions={
        youHold.value ? (
          <Button label={t('control.give')} onClick={() => (onClose(), void releaseControl())} />
        ) : (
          <Button label={t('control.take')} tone="primary" disabled={!connected.value || !mayTake.value || wait !== null} title={!connected.value ? t('why.offline') : mayTake.value ? undefined : t('control.roleWatch')} onClick={() => void takeControl(false)} />
        )
      }
    >
      <p class="control-state">
        <Icon name={youHold.value ? 'hand' : 'eye'} size={28} />
        <strong>{words()}</strong>
      </p>
      {wait && <p role="status">{t('control.wait', { name: wait.name || t('control.someone'), seconds: left })}</p>}
      <p>{mayTake.value ? t('control.text') : `${t('control.roleWatch')}. ${t('control.roleMore')}`}</p>
      <Field
        label={t('control.name')}
        value={settings.clientName.value}
        onChange={(name) => (settings.clientName.value = name.trim() || settings.clientName.value)}
      />
    </Dialog>
  );
}

export function ControlQuestion() {
  const who = asked.value;
  const left = useSecondsLeft(who?.until ?? null);
  if (!who) return null;
  return (
    <Dialog
      title={t('control.askedTitle', { name: who.name || t('control.someone') })}
      actions={
        <>
          <Button label={t('control.keep')} onClick={() => void answerQuestion(false)} />
          <Button label={t('control.giveIt')} tone="primary" onClick={() => void answerQuestion(true)} />
        </>
      }
    >
      <p>{t('control.askedText', { seconds: left })}</p>
    </Dialog>
  );
}

/** Whole seconds until `until` (performance.now()). Renders again every second. */
function useSecondsLeft(until: number | null): number {
  const [now, setNow] = useState(() => performance.now());
  useEffect(() => {
    if (until === null) return;
    setNow(performance.now());
    const timer = setInterval(() => setNow(performance.now()), 250);
    return () => clearInterval(timer);
  }, [until]);
  return until === null ? 0 : Math.max(0, Math.ceil((until - now) / 1000));
}
