/**
 * Control of the cell: the button that shows who has it, the dialog to take or release it, and the question
 * when another client asks for it.
 */
import { useEffect, useState } from 'preact/hooks';
import { t } from '../i18n';
import { answerQuestion, asked, connected, holder, releaseControl, takeControl, waiting, youHold } from '../state/cell';
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
  return t(youHold.value ? 'control.youShort' : holder.value ? 'control.otherShort' : 'control.freeShort');
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

/** A strip on pages that move the robot: says that this page has no control, and how to take it. */
export function WatchOnly() {
  if (!connected.value || youHold.value) return null;
  return <Watching />;
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
          <Button label={t('control.take')} tone="primary" disabled={!connected.value || wait !== null} title={connected.value ? undefined : t('why.offline')} onClick={() => void takeControl(false)} />
        )
      }
    >
      <p class="control-state">
        <Icon name={youHold.value ? 'hand' : 'eye'} size={28} />
        <strong>{words()}</strong>
      </p>
      {wait && <p role="status">{t('control.wait', { name: wait.name || t('control.someone'), seconds: left })}</p>}
      <p>{t('control.text')}</p>
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
