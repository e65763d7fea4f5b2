/** Describes what holds back the motion whose key is held. */
import { type Key, t } from '../../i18n';
import { heldBack, heldKey } from '../../state/jog';
import {jointTitle} from '../../ui/format';

/** '' if nothing holds it back, or if no key is held. */
export function heldWords(): string {
  const told = heldKey.value !== '' ? heldBack.value : null;
  if (!told || told.what === 'speed') return '';
  const words = t(`move.held.${told.what}` as Key);
  return told.which ? `${words} (${told.what === 'limit' ? jointTitle(told.which) : told.which})` : words;
}
