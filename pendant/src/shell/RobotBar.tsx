/** Always at the bottom: the state in words, the modes, the speed, hold and resume, and Stop. */
import { t } from '../i18n';
import { discard, hold, recover, resume, setOverride, setProfile, stop } from '../state/actions';
import { connected, mayMove, programRuns, status } from '../state/cell';
import { ask, close } from '../ui/ask';
import { Button, Slider } from '../ui/controls';
import { Icon } from '../ui/Icon';
import { stateWord } from './words';

export function RobotBar() {
  return (
    <footer class="robot-bar" aria-label={t('bar.label')}>
      <StateShown />
      <Modes />
      <Override />
      <Go />
      <StopButton />
    </footer>
  );
}

function StateShown() {
  const word = stateWord();
  return (
    <div class={`state ${word.tone}`} role="status" aria-label={t('state.label')} title={word.why || undefined}>
      <span class="sign">
        <Icon name={word.icon} size={22} />
      </span>
      <span class="words">
        <strong>{word.text}</strong>
        {word.why && <small>{word.why}</small>}
      </span>
    </div>
  );
}

function Modes() {
  const now = status.value;
  if (!now) return <div class="modes" />;
  return (
    <div class="modes" role="group" aria-label={t('mode.label')}>
      <span class={`chip ${now.simulated ? '' : 'warn'}`}>
        <Icon name={now.simulated ? 'cube' : 'power'} size={16} />
        {t(now.simulated ? 'mode.simulated' : 'mode.real')}
      </span>
      {now.armed || now.simulated ? (
        <ProfileChip />
      ) : (
        <a class="chip warn" href="#/cell">
          {t('mode.notArmed')}
        </a>
      )}
    </div>
  );
}

function ProfileChip() {
  const reduced = status.value?.profile === 'reduced';
  const toFull = () =>
    ask({
      title: t('mode.toFull'),
      text: t('mode.toFullText'),
      action: t('mode.toFullDo'),
      onYes: () => void setProfile('full'),
    });
  return (
    <button
      type="button"
      class={`chip ${reduced ? 'good' : ''}`}
      title={t(reduced ? 'mode.reducedWhy' : 'mode.fullWhy')}
      disabled={!mayMove.value}
      onClick={() => (reduced ? toFull() : void setProfile('reduced'))}
    >
      {t(reduced ? 'mode.reduced' : 'mode.full')}
    </button>
  );
}

let latest = -1;
let underway = false;
/** The newest value goes out as soon as the one before was answered. */
function dragOverride(percent: number): void {
  latest = percent;
  if (underway) return;
  underway = true;
  const sent = percent;
  void setOverride(percent).finally(() => {
    underway = false;
    if (latest !== sent) dragOverride(latest);
  });
}

function Override() {
  const now = status.value;
  const percent = Math.round(now?.override ?? 100);
  const allowed = now?.allowed ?? 100;
  return (
    <div class="override">
      <Slider
        label={t('bar.speed')}
        value={percent}
        min={0}
        max={100}
        step={1}
        unit="%"
        disabled={!mayMove.value}
        onInput={dragOverride}
        onChange={dragOverride}
      />
      {allowed < 100 && <small>{t('bar.allowed', { percent: Math.round(allowed) })}</small>}
    </div>
  );
}

function moves(): boolean {
  return status.value?.moving === true || programRuns.value;
}

/** The one thing that a person may want next: hold what goes, resume what is held, recover from a fault. */
function Go() {
  const state = status.value?.state;
  if (state === 'fault')
    return (
      <div class="go">
        <Button label={t('bar.recover')} icon="undo" big tone="warn" disabled={!mayMove.value} onClick={() => void recover()} />
      </div>
    );
  if (state === 'held')
    return (
      <div class="go">
        {status.value?.moving === false && (
          <Button
            label={t('bar.discard')}
            icon="trash"
            bare
            big
            disabled={!mayMove.value}
            onClick={() =>
              ask({ title: `${t('bar.discard')}?`, text: t('bar.discardText'), action: t('bar.discard'), onYes: () => void discard() })
            }
          />
        )}
        <Button label={t('bar.resume')} icon="run" big tone="good" disabled={!mayMove.value} onClick={() => void resume()} />
      </div>
    );
  return (
    <div class="go">
      <Button label={t('bar.hold')} icon="pause" big tone={moves() ? 'warn' : 'plain'} disabled={!connected.value} onClick={() => void hold()} />
    </div>
  );
}

export function StopButton() {
  return (
    <button
      type="button"
      class="stop-button"
      aria-keyshortcuts="Escape"
      onPointerDown={(e) => {
        e.preventDefault();
        close();
        void stop();
      }}
      onKeyDown={(e) => {
        if (e.key !== 'Enter' && e.key !== ' ') return;
        e.preventDefault();
        void stop();
      }}
      onClick={(e) => {
        // A pointer has stopped at its press already; what remains are clicks that no pointer made.
        if (e.detail === 0) void stop();
      }}
    >
      <span class="stop-sign" aria-hidden="true">
        <Icon name="stop" size={22} />
      </span>
      <span class="stop-words">
        <strong>{t('stop.label')}</strong>
        <kbd>{t('stop.key')}</kbd>
        <small>{t('stop.note')}</small>
      </span>
    </button>
  );
}
