/** The state of the cell in a word, with its colour and icon. */
import { type Key, t } from '../i18n';
import { causeWords } from '../i18n/told';
import { link, pausing, status } from '../state/cell';
import { loopStands, waitsFor } from '../state/standing';
import { afterContact } from './AlarmStrip';
import { mustLogIn } from './LogIn';
import type { IconName } from '../ui/Icon';

export interface StateWord {
  text: string;
  tone: 'good' | 'busy' | 'warn' | 'bad' | 'off';
  icon: IconName;
  /** The reason for the state, if there is one to report. */
  why: string;
}

export function stateWord(): StateWord {
  const now = status.value;
  if (!now) {
    if (mustLogIn.value) return { text: t('login.title'), tone: 'off', icon: 'lock', why: '' };
    const text = t({ connecting: 'link.connecting', open: 'link.connecting', lost: 'state.reconnecting', refused: 'link.refused' }[link.value] as Key);
    return { text, tone: 'off', icon: 'link', why: '' };
  }
  if (loopStands.value) return { text: t('state.stands'), tone: 'bad', icon: 'alarm', why: waitsFor() && t('state.standsFor', { name: waitsFor() }) };
  const why = causeWords(now.causeCode, now.cause, now.causeFacts);
  switch (now.state) {
    case 'fault':
      return afterContact() ? { text: t('state.contact'), tone: 'bad', icon: 'alarm', why: '' } : { text: t('state.fault'), tone: 'bad', icon: 'alarm', why };
    case 'stopping':
      return { text: t('state.stopping'), tone: 'warn', icon: 'pause', why };
    case 'held':
      if (afterContact()) return { text: t('state.contact'), tone: 'bad', icon: 'alarm', why: '' };
      return { text: t('state.held'), tone: 'warn', icon: 'pause', why };
    case 'backing':
      return { text: t('state.backing'), tone: 'busy', icon: 'turnLeft', why };
    case 'no cell':
      return { text: t('state.noCell'), tone: 'off', icon: 'cell', why: '' };
    default:
      return runningWord();
  }
}

function runningWord(): StateWord {
  const now = status.value!;
  const word = (text: string, tone: StateWord['tone'], icon: IconName) => ({ text, tone, icon, why: '' });
  if (!now.simulated && !now.armed) return word(t('state.notArmed'), 'warn', 'lock');
  const wanting = now.inactive.length > 0 ? t('state.inactive', {names: now.inactive.join(', ')}) : '';
  const going = goingWord();
  if (going) return {...going, why: wanting || (now.override === 0 ? t('bar.speedZero') : '')};
  if (wanting) return {...word(t('state.notReady'), 'warn', 'power'), why: wanting};
  return word(t('state.ready'), 'good', 'check');
}

/** The activity of a running cell; null if it neither moves nor runs a program. */
function goingWord(): StateWord|null {
  const now = status.value!;
  const word = (text: string, tone: StateWord['tone'], icon: IconName) => ({text, tone, icon, why: ''});
  if (now.jogged.length > 0 && now.moving)
    return word(t('state.jogging'), 'busy', 'hand');
  const program = now.program;
  if (!program || program.ended || program.ready)
    return now.moving ? word(t('state.moving'), 'busy', 'run') : null;
  if (pausing.value) return word(t('state.pausing'), 'warn', 'clock');
  if (program?.paused) return word(t('state.programPaused'), 'warn', 'pause');
  if (program?.state === 'running') return word(t('state.programRuns'), 'busy', 'run');
  if (program?.state === 'waiting' && now.moving) return word(t('state.programRuns'), 'busy', 'run');
  if (program?.state === 'waiting') return word(t('state.programWaits'), 'busy', 'clock');
  return now.moving ? word(t('state.moving'), 'busy', 'run') : null;
}
