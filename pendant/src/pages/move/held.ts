/** Describes what holds back the motion whose key is held. */
import { type Key, number, t } from '../../i18n';
import { bodyWords } from '../../i18n/told';
import { nears, robot } from '../../state/cell';
import { heldBack, heldKey } from '../../state/jog';
import {jointTitle} from '../../ui/format';

/** '' if nothing holds it back, or if no key is held. */
export function heldWords(): string {
  const told = heldKey.value !== '' ? heldBack.value : null;
  if (!told || told.what === 'speed') return '';
  const near = told.what === 'body' ? nears.value[robot.value?.name ?? ''] : undefined;
  if (near) return t('move.heldBefore', {a: bodyWords(near.a), b: bodyWords(near.b), mm: number(1000 * near.distance, 0)});
  const words = t(`move.held.${told.what}` as Key);
  return told.which ? `${words} (${told.what === 'limit' ? jointTitle(told.which) : told.which})` : words;
}
