/** On pages that move something: lists the bodies whose contacts nothing checks. */
import { t } from '../i18n';
import { problemWords } from '../i18n/told';
import { status } from '../state/cell';
import { Icon } from '../ui/Icon';
import { pageId } from './route';

const kMoving = ['run', 'move', 'program'];

export function Bodies() {
  const told = status.value?.contacts;
  if (!told || !kMoving.includes(pageId.value) || (told.checked && told.unchecked.length === 0)) return null;
  const which = told.unchecked.map((each) => problemWords(each).text).join(' · ');
  const text = told.checked ? t('bodies.some', { count: told.unchecked.length, names: which }) : t('bodies.none');
  return (
    <p class="bodies" role="note" title={which || text}>
      <Icon name="eye" size={18} /> <span>{text}</span>
    </p>
  );
}
