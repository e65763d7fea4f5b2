/**
 * The bar at the bottom of every page: the state in words, the modes, the speed, pause and resume, and Stop.
 */
import { type Key, t } from '../i18n';
import { discard, goOn, hold, recover, setProfile, stop } from '../state/actions';
import { connected, mayMove, programRuns, status, ways } from '../state/cell';
import { loopStands } from '../state/standing';
import { canBe, type Next } from '../state/ways';
import { ask, close, open } from '../ui/ask';
import { Button, type Tone } from '../ui/controls';
import { Icon, type IconName } from '../ui/Icon';
import { activateAll } from './activate';
import { ArmDialog } from './ArmDialog';
import { blockedWords } from './blocked';
import { Override } from './Override';
import { stateWord } from './words';

export function RobotBar() {
  return (
    <footer class="robot-bar" aria-label={t('bar.label')}>
      <div class="bar-top">
        <StateShown />
        <Modes />
        <Override />
      </div>
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
        <span class="chip warn">{t('mode.notArmed')}</span>
      )}
    </div>
  );
}

function ProfileChip() {
  const reduced = status.value?.profile === 'reduced';
  if (!reduced && status.value?.reduced)
    return (
      <span class="chip good" title={t('mode.firstRunWhy')}>
        {t('mode.reduced')}
      </span>
    );
  const toFull = () =>
    ask({
      title: t('mode.toFull'),
      text: t('mode.toFullText'),
      action: t('mode.toFullDo'),
      onYes: () => void setProfile('full'),
      still: () => mayMove.value,
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

const kNext: Record<Next, { label: Key; icon: IconName; tone: Tone; press: () => void }> = {
  pause: { label: 'bar.hold', icon: 'pause', tone: 'plain', press: () => void hold() },
  resume: { label: 'bar.resume', icon: 'run', tone: 'good', press: () => void goOn() },
  recover: { label: 'bar.recover', icon: 'undo', tone: 'warn', press: () => void recover() },
  arm: { label: 'cell.arm', icon: 'lock', tone: 'warn', press: () => open((close) => <ArmDialog onClose={close} />) },
  activate: { label: 'state.activate', icon: 'power', tone: 'warn', press: activateAll },
};

/** The most likely next action: pause, resume, recover, arm or activate. */
function Go() {
  const { next, nextBlocked, resumesToo, discard: forget, discards } = ways.value;
  const { label, icon, tone, press } = kNext[next];
  const forgets: Key = discards === 'motion' ? 'bar.discard' : 'bar.accept';
  return (
    <div class="go">
      {forget !== null && (
        <Button
          label={t(forgets)}
          class="cancel-motion"
          disabled={!canBe(forget)}
          onClick={() => ask({ title: `${t(forgets)}?`, text: t(discards === 'motion' ? 'bar.discardText' : 'bar.acceptText'), action: t(forgets), onYes: () => void discard(), still: () => canBe(ways.value.discard ?? 'why.noProgram') })}
        />
      )}
      {resumesToo !== null && <Button label={t('bar.resume')} class="cancel-motion" disabled={!canBe(resumesToo)} onClick={() => void goOn()} />}
      <Button label={t(label)} icon={icon} big tone={next === 'pause' && moves() ? 'warn' : tone} disabled={!canBe(nextBlocked)} title={blockedWords(nextBlocked) || undefined} onClick={press} />
    </div>
  );
}

/**
 * Always in the same corner at the same size. Without a connection, a cell or a control loop that runs it says that it has
 * no effect, but still sends the request.
 */
export function StopButton() {
  const dead: Key | null = !connected.value ? 'stop.offline' : status.value?.state === 'no cell' ? 'stop.noCell' : loopStands.value ? 'stop.stands' : null;
  return (
    <button
      type="button"
      class={`stop-button ${dead ? 'dead' : ''}`}
      aria-keyshortcuts="Escape"
      aria-disabled={dead !== null || undefined}
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
        // A pointer has already stopped at its press. This handles clicks without a pointer.
        if (e.detail === 0) void stop();
      }}
    >
      <span class="stop-sign" aria-hidden="true">
        <Icon name="stop" size={22} />
      </span>
      <span class="stop-words">
        <strong>{t('stop.label')}</strong>
        <kbd>{t('stop.key')}</kbd>
        <small>{t(dead ?? 'stop.note')}</small>
      </span>
    </button>
  );
}
