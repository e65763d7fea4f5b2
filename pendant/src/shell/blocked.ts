/** Why a key cannot be pressed, in few words. */
import {type Key, t} from '../i18n';
import {problemWords} from '../i18n/told';
import type {Blocked} from '../state/ways';

/** What to do first, by what the cell says is in the way. */
const kFirst: Record<string, Key> = {
  disarmed: 'why.armFirst',
  fault: 'why.recoverFirst',
  held: 'why.resumeFirst',
  'motion-held': 'why.motionFirst',
  moving: 'why.moving',
  'not-active': 'why.activateFirst',
  'program-runs': 'why.programFirst',
  stopping: 'why.stopping',
};

/** '' where it can be pressed. Who has no control reads that elsewhere. */
export function blockedWords(blocked: Blocked): string {
  if (blocked === '' || blocked === 'why.control') return '';
  if (typeof blocked === 'string') return t(blocked);
  const first = kFirst[blocked.code];
  if (first) return t(first);
  const {text, advice} = problemWords(blocked);
  return [text, advice].filter(Boolean).join('. ');
}
