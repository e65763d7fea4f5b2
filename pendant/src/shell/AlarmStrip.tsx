/** One strip for what went wrong and nobody has looked at yet; after a contact it leads back. */
import { effect } from '@preact/signals';
import { number, t } from '../i18n';
import { ofContact, plain, problemWords } from '../i18n/told';
import { alarms, attempt, connected, markSeen, mayMove, status } from '../state/cell';
import { discard, recover, resume } from '../state/actions';
import { open } from '../ui/ask';
import { Button } from '../ui/controls';
import { Icon } from '../ui/Icon';
import { Alarms } from './Alarms';
import { go, pageId } from './route';

/** Who goes on after a contact has seen it. */
let before = '';
effect(() => {
  const now = status.value?.state ?? '';
  if (now === 'running' && (before === 'held' || before === 'fault')) markSeen((each) => each.code === 'contact');
  before = now;
});

export function AlarmStrip() {
  if (!connected.value) return null;
  if (afterContact()) return <WayBack />;
  const unseen = alarms.value.filter((each) => !each.seen);
  const alarm = unseen.filter((each) => each.severity === 'error').pop() ?? unseen[unseen.length - 1];
  if (!alarm) return null;
  const told = problemWords(alarm);
  return (
    <section class={`alarm-strip ${alarm.severity}`} role="alert" aria-label={t('alarms.strip')}>
      <Icon name="alarm" size={22} />
      <p>
        <strong>{told.text}</strong>
        {(told.detail || told.advice) && <span> {[told.detail, told.advice].filter(Boolean).join(' · ')}</span>}
      </p>
      {unseen.length > 1 && <span class="chip">{t('alarms.more', { count: unseen.length - 1 })}</span>}
      <Button label={t('alarms.details')} onClick={() => open((close) => <Alarms onClose={close} />)} />
      <Button label={t('alarms.ok')} icon="check" bare onClick={() => markSeen(() => true)} />
    </section>
  );
}

/** The cell stands because something touched what it should not. */
export function afterContact(): boolean {
  const now = status.value;
  if (!now || !['held', 'fault', 'stopping'].includes(now.state)) return false;
  return now.causeCode === 'contact' || (now.causeCode === '' && ofContact(now.cause)) || contactSince();
}

/** The newest error is a contact that nobody has gone on after. */
function contactSince(): boolean {
  const last = alarms.value.filter((each) => each.severity === 'error').pop();
  return last?.code === 'contact' && !last.seen;
}

function pairs(): string {
  const list = status.value?.contacts.list ?? [];
  const shown = list.some((each) => each.now) ? list.filter((each) => each.now) : list.slice(-1);
  if (shown.length) return shown.map((each) => t('contact.pair', { a: each.a, b: each.b, mm: number(1000 * each.depth, 1) })).join(' · ');
  const told = alarms.value.filter((each) => each.code === 'contact').pop();
  return told ? plain(told.what) : '';
}

/** Out of a contact, step by step; each step that can be taken now has its key. */
function WayBack() {
  const now = status.value!;
  const may = mayMove.value;
  const held = now.state === 'held';
  const can = (what: string) => held && !now.cannot[what];
  return (
    <section class="alarm-strip error way-back" role="alert" aria-label={t('contact.title')}>
      <Icon name="alarm" size={22} />
      <div>
        <strong>{t('contact.title')}</strong> <span>{pairs()}</span>
        <ol>
          <li>{t(now.state === 'fault' ? 'contact.recover' : now.motionLeft ? 'contact.cancel' : 'contact.canceled')}</li>
          <li>{t(now.contacts.touching ? 'contact.away' : 'contact.clear')}</li>
          <li>{t('contact.resume')}</li>
        </ol>
      </div>
      <div class="row">
        {now.state === 'fault' && <Button label={t('bar.recover')} icon="undo" tone="warn" disabled={!may} onClick={() => void recover()} />}
        {can('discard') && now.motionLeft && <Button label={t('bar.discard')} disabled={!may} onClick={() => void discard()} />}
        {can('back') && now.motionLeft && <Button label={t('contact.back')} icon="undo" disabled={!may} onClick={() => void attempt('control.back', { time: 0.5 })} />}
        {held && pageId.value !== 'move' && <Button label={t('contact.jog')} icon="move" onClick={() => go('move')} />}
        {can('resume') && !now.contacts.touching && <Button label={t('bar.resume')} icon="run" tone="good" disabled={!may} onClick={() => void resume()} />}
      </div>
    </section>
  );
}
