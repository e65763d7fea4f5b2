/** What a stop after a contact says: which bodies, how deep, or which joint felt it. No side effects. */
import { number, t } from '../i18n';
import { bodyWords, problemWords } from '../i18n/told';
import type { Alarm, Contacts, Touch } from '../wire/types';

/** Alarms of unexpected contacts: seen in the scene, or felt by the motors. */
export const kContactCodes: ReadonlySet<string> = new Set(['contact', 'collision-torque']);

/** In mm; below 0.1 mm with two significant digits. */
export function depthWords(metres: number): string {
  const mm = 1000 * metres;
  if (mm >= 0.1 || mm <= 0) return number(mm, 1);
  return number(mm, Math.min(6, 1 - Math.floor(Math.log10(mm))));
}

export interface ContactWords {
  text: string;
  /** Only the motors felt it: whether something still touches is unknown. */
  felt: boolean;
}

export function contactWords(contacts: Contacts, alarms: readonly Alarm[]): ContactWords {
  const last = alarms.filter((each) => kContactCodes.has(each.code)).pop();
  const now = contacts.list.filter((each) => each.now);
  const felt = last?.code === 'collision-torque' && now.length === 0;
  if (felt) return { text: problemWords(last!).text, felt };
  const shown = now.length ? now : contacts.list.slice(-1);
  const pairs = shown.map((each) => t('contact.pair', { a: bodyWords(each.a), b: bodyWords(each.b), mm: depthWords(each.depth) }));
  return { text: pairs.join(' · ') || (last ? problemWords(last).text : ''), felt };
}

/** True if the body, as contacts name it, is of the robot or in its hand. */
const isOf = (robot: string, body: string): boolean => body.startsWith(`${robot}/`) || body === `the part held by ${robot}`;

/** What the robot touches now; undefined: nothing. */
export const touchOf = (robot: string, list: readonly Touch[]): Touch | undefined => list.find((each) => each.now && (isOf(robot, each.a) || isOf(robot, each.b)));

/** The robots that touch something now, of those with these `names`; else those of the last contact. */
export function robotsInContact(contacts: Contacts, alarms: readonly Alarm[], names: readonly string[]): string[] {
  const last = alarms.filter((each) => kContactCodes.has(each.code)).pop();
  const now = contacts.list.filter((each) => each.now);
  const felt = last?.code === 'collision-torque' && now.length === 0;
  const touches = felt ? [] : now.length ? now : contacts.list.slice(-1);
  const bodies = felt ? [String(last!.facts?.joint ?? '')] : touches.flatMap((each) => [each.a, each.b]);
  return names.filter((name) => bodies.some((body) => isOf(name, body)));
}
