/** Short reasons why a key is disabled. */
import {type Key, t} from '../i18n';
import {problemWords} from '../i18n/told';
import type {Blocked} from '../state/ways';

/** What to do first, by the code of the cell's reason. */
const kFirst: Record<string, Key> = {
  disarmed: 'why.armFirst',
  fault: 'why.recoverFirst',
  'forward-mode': 'why.forwardMode',
  held: 'why.resumeFirst',
  'motion-held': 'why.motionFirst',
  moving: 'why.moving',
  'not-active': 'why.activateFirst',
  'program-runs': 'why.programFirst',
  stopping: 'why.stopping',
};

/** '' if the key is enabled. The lack of control is reported elsewhere. */
export function blockedWords(blocked: Blocked): string {
  if (blocked === '' || blocked === 'why.control') return '';
  if (typeof blocked === 'string') return t(blocked);
  const first = kFirst[blocked.code];
  if (first) return t(first);
  const {text, advice} = problemWords(blocked);
  return [text, advice].filter(Boolean).join('. ');
}
