/** A strip for problems that nobody has acknowledged. After a contact it shows the steps of recovery. */
import { effect } from '@preact/signals';
import { type Key, t } from '../i18n';
import { forwardRobots, problemWords } from '../i18n/told';
import { alarms, cell, connected, markSeen, mayMove, pausing, robot, robotName, status, ways } from '../state/cell';
import { back, discard, recover, resume } from '../state/actions';
import { lastRefusal } from '../state/recovery';
import { canBe, waysOf } from '../state/ways';
import { open } from '../ui/ask';
import { Button } from '../ui/controls';
import { placeIn } from '../ui/format';
import { Icon } from '../ui/Icon';
import { Alarms } from './Alarms';
import { blockedWords } from './blocked';
import { contactWords, kContactCodes, robotsInContact } from './contact';
import { go, pageId } from './route';

/** Alarms of a hold that are over when the cell runs again. */
const kOver = new Set([...kContactCodes, 'guard', 'guard-deadlock', 'guard-workspace', 'guard-crowded', 'program-hold', 'held']);

/**
 * An operator who brings the cell back after a contact, a hold or a fault has seen its alarm. These are the previous
 * states.
 */
let stood = false;
let wanted = false;
effect(() => {
  const now = status.value;
  const runs = now?.state === 'running';
  const wants = (now?.inactive.length ?? 0) > 0;
  if (runs && stood) markSeen((each) => kOver.has(each.code));
  if (runs && !wants && (stood || wanted)) markSeen((each) => each.code === 'fault');
  stood = now?.state === 'held' || now?.state === 'fault';
  wanted = wants;
});

export function AlarmStrip() {
  if (!connected.value) return null;
  if (afterContact()) return <WayBack />;
  const unseen = alarms.value.filter((each) => !each.seen);
  const errors = unseen.filter((each) => each.severity === 'error');
  // A cell that could not start has all errors of its files: people mend the first one first.
  const alarm = (status.value?.state === 'no cell' ? errors[0] : errors[errors.length - 1]) ?? unseen[unseen.length - 1];
  if (!alarm) return null;
  // The latest refusal replaces the first cause, which may be over.
  const refusal = alarm.code === 'fault' ? lastRefusal.value : null;
  const told = problemWords(refusal ?? alarm);
  const advice = alarm.code === 'fault' ? afterFault() : told.advice;
  return (
    <section class={`alarm-strip ${alarm.severity}`} role="alert" aria-label={t('alarms.strip')}>
      <Icon name="alarm" size={22} />
      <p>
        <strong>{told.text}</strong>
        {alarm.where && <code> {placeIn(cell.value?.folder ?? '', alarm.where)}</code>}
        {(told.detail || advice) && <span> {[told.detail, advice].filter(Boolean).join(' · ')}</span>}
      </p>
      {unseen.length > 1 && <span class="chip">{t('alarms.more', { count: unseen.length - 1 })}</span>}
      <Button label={t('alarms.details')} class="alarm-details" onClick={() => open((close) => <Alarms onClose={close} />)} />
      <Button label={t('alarms.ok')} icon="check" bare onClick={() => markSeen(() => true)} />
    </section>
  );
}

/** The next step after a fault, or what is in its way; '' once the cell runs again. */
export function afterFault(): string {
  const { next, nextBlocked } = ways.value;
  const why = next === 'resume' ? blockedWords(nextBlocked) : '';
  if (why) return why;
  const step = ({ recover: 'do.fault', activate: 'do.fault.activate', arm: 'do.disarmed', resume: 'do.fault.resume' } as Record<string, Key>)[next];
  return step ? t(step) : '';
}

/** True if the cell does not run because of an unexpected contact. */
export function afterContact(): boolean {
  const now = status.value;
  if (!now || !['held', 'fault', 'stopping'].includes(now.state)) return false;
  return now.causeCode === 'contact' || contactSince();
}

/** True if the newest error is a contact that nobody has acknowledged. */
function contactSince(): boolean {
  const last = alarms.value.filter((each) => each.severity === 'error').pop();
  return !!last && kContactCodes.has(last.code) && !last.seen;
}

/** The steps of recovery after a contact. Each step that is possible now has its key. */
function WayBack() {
  const now = status.value!;
  // A step that the state forbids is not shown. A page without control shows the other steps disabled.
  const { next, nextBlocked, discard: forget, back: backwards } = waysOf({ status: now, mayMove: true, pausing: pausing.value });
  const held = now.state === 'held';
  const may = mayMove.value;
  const names = (cell.value?.robots ?? []).map((each) => each.name);
  const touching = robotsInContact(now.contacts, alarms.value, names);
  const others = forwardRobots.value;
  /** Nobody jogs any of these robots here. */
  const forward = others.all || (touching.length > 0 && touching.every((name) => others.names.includes(name)));
  /** The page Move shows a robot that touches something and that can be jogged. */
  const jogAway = () => {
    const able = touching.filter((name) => !others.names.includes(name));
    if (able[0] && !able.includes(robot.value?.name ?? '')) robotName.value = able[0];
    go('move');
  };
  const { text, felt } = contactWords(now.contacts, alarms.value);
  const steps: Key[] = [
    now.state === 'fault'
      ? 'contact.recover'
      : now.motionLeft
        ? now.contacts.touching
          ? 'contact.cancel'
          : 'contact.cancelFirst' // Resume would repeat the motion into the same contact
        : 'contact.canceled',
    now.contacts.touching ? (forward ? 'contact.awayForward' : 'contact.away') : felt ? (forward ? 'contact.feltForward' : 'contact.felt') : 'contact.clear',
    'contact.resume',
  ];
  /** The index of the present step. A phone shows only this step. */
  const at = now.state === 'fault' || now.motionLeft ? 0 : now.contacts.touching || felt ? 1 : 2;
  return (
    <section class="alarm-strip error way-back" role="alert" aria-label={t('contact.title')}>
      <Icon name="alarm" size={22} />
      <div>
        <strong>{t('contact.title')}</strong> <span>{text}</span>
        <ol>
          {steps.map((key, i) => (
            <li key={i} value={i + 1} aria-current={i === at ? 'step' : undefined}>
              {t(key)}
            </li>
          ))}
        </ol>
      </div>
      <div class="row">
        {next === 'recover' && <Button label={t('bar.recover')} icon="undo" tone="warn" disabled={!may || !canBe(nextBlocked)} onClick={() => void recover()} />}
        {forget !== null && canBe(forget) && <Button label={t('bar.discard')} tone={now.motionLeft && !now.contacts.touching ? 'primary' : undefined} disabled={!may} onClick={() => void discard()} />}
        {held && canBe(backwards) && <Button label={t('contact.back')} icon="undo" disabled={!may} onClick={() => void back()} />}
        {held && !forward && (pageId.value !== 'move' || (names.length > 1 && touching.length > 0 && !touching.includes(robot.value?.name ?? ''))) && <Button label={t('contact.jog')} icon="move" onClick={jogAway} />}
        {next === 'resume' && canBe(nextBlocked) && !now.contacts.touching && <Button label={t('bar.resume')} icon="run" tone={now.motionLeft ? undefined : 'good'} disabled={!may} onClick={() => void resume()} />}
      </div>
    </section>
  );
}
