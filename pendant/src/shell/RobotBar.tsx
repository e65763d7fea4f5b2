/** Always at the bottom: the state in words, the modes, the speed, pause and resume, and Stop. */
import { t } from '../i18n';
import { discard, goOn, hold, isPaused, recover, setProfile, stop, touches } from '../state/actions';
import { connected, mayMove, programRuns, status } from '../state/cell';
import { ask, close } from '../ui/ask';
import { Button } from '../ui/controls';
import { Icon } from '../ui/Icon';
import { activateAll } from './activate';
import { Override } from './Override';
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
  if (!now || now.state === 'no cell') return <div class="modes" />;
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

function moves(): boolean {
  return status.value?.moving === true || programRuns.value;
}

/** The one thing that a person may want next: pause what goes, resume what is paused, recover from a fault. */
function Go() {
  const now = status.value;
  const may = mayMove.value;
  if (now?.state === 'fault')
    return (
      <div class="go">
        <Button label={t('bar.recover')} icon="undo" big tone="warn" disabled={!may} onClick={() => void recover()} />
      </div>
    );
  if (now?.state === 'running' && (now.simulated || now.armed) && now.inactive.length > 0)
    return (
      <div class="go">
        <Button label={t('state.activate')} icon="power" big tone="warn" disabled={!may} onClick={activateAll} />
      </div>
    );
  if (isPaused())
    return (
      <div class="go">
        {now?.state === 'held' && now.moving === false && now.motionLeft && (
          <Button
            label={t('bar.discard')}
            class="cancel-motion"
            disabled={!may}
            onClick={() => ask({ title: `${t('bar.discard')}?`, text: t('bar.discardText'), action: t('bar.discard'), onYes: () => void discard() })}
          />
        )}
        <Button label={t('bar.resume')} icon="run" big tone="good" disabled={!may || touches()} onClick={() => void goOn()} />
      </div>
    );
  return (
    <div class="go">
      <Button label={t('bar.hold')} icon="pause" big tone={moves() ? 'warn' : 'plain'} disabled={!connected.value || now?.state === 'no cell'} onClick={() => void hold()} />
    </div>
  );
}

/** In its corner at its size whatever else is shown. Without a connection it says that it does nothing, and is still tried. */
export function StopButton() {
  const dead = !connected.value;
  return (
    <button
      type="button"
      class={`stop-button ${dead ? 'dead' : ''}`}
      aria-keyshortcuts="Escape"
      aria-disabled={dead || undefined}
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
        <small>{t(dead ? 'stop.offline' : 'stop.note')}</small>
      </span>
    </button>
  );
}
