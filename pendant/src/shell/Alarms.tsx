import { t } from '../i18n';
import { alarms } from '../state/cell';
import { clockTime } from '../ui/format';
import { Button, Empty } from '../ui/controls';
import { Dialog } from '../ui/Dialog';

/** What went wrong, newest first, with cause and remedy. */
export function Alarms({ onClose }: { onClose: () => void }) {
  const seen = () => (alarms.value = alarms.value.map((each) => ({ ...each, seen: true })));
  const list = [...alarms.value].reverse();
  return (
    <Dialog
      title={t('alarms.label')}
      onClose={onClose}
      side
      actions={list.some((each) => !each.seen) ? <Button label={t('alarms.seen')} icon="check" onClick={seen} /> : undefined}
    >
      {list.length === 0 ? (
        <Empty icon="check" text={t('alarms.none')} />
      ) : (
        <ul class="alarms">
          {list.map((alarm, i) => (
            <li key={list.length - i} class={`${alarm.severity} ${alarm.seen ? 'seen' : ''}`}>
              <p class="when">
                <time>{clockTime(alarm.time)}</time> <code>{alarm.code}</code> {alarm.where}
              </p>
              <p class="what">{alarm.what}</p>
              {alarm.advice && (
                <p>
                  <b>{t('alarms.do')}:</b> {alarm.advice}
                </p>
              )}
            </li>
          ))}
        </ul>
      )}
    </Dialog>
  );
}
