/** Says which planned move is slower than it was planned, and why. */
import { number, t } from '../i18n';
import { bodyWords } from '../i18n/told';
import type { Near } from '../wire/types';

/** The robot of a body, as contacts name it: `left` of `left/forearm_link`; '' if it is not of a robot. */
const robotOf = (body: string, robots: readonly string[]): string => robots.find((name) => body.startsWith(`${name}/`)) ?? '';

/** The slowest move first. '' if no move is slower than planned. A robot waits for another only while the cell runs. */
export function slowedWords(nears: readonly Near[], robots: readonly string[], runs: boolean): string {
  const slow = nears.filter((each) => each.pace < 0.95).sort((a, b) => a.pace - b.pace)[0];
  if (!slow) return '';
  const words = { a: bodyWords(slow.a), b: bodyWords(slow.b), mm: number(1000 * slow.distance, 0) };
  if (slow.pace > 0) return t('view.slowed', words);
  const [mine, other] = [robotOf(slow.a, robots), robotOf(slow.b, robots)];
  if (runs && mine && other && mine !== other) return t('view.waits', { ...words, robot: mine, other });
  return t('view.heldBefore', words);
}
