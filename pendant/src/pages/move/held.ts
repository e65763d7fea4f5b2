/** What holds back the motion whose key is held, in words. */
import { type Key, t } from '../../i18n';
import { heldBack, heldKey } from '../../state/jog';
import {jointTitle} from '../../ui/format';

/** '' where nothing does, or where no key is held. */
export function heldWords(): string {
  const told = heldKey.value !== '' ? heldBack.value : null;
  if (!told || told.what === 'speed') return '';
  const words = t(`move.held.${told.what}` as Key);
  return told.which ? `${words} (${told.what === 'limit' ? jointTitle(told.which) : told.which})` : words;
}
