import { t } from '../i18n';
import { problemWords } from '../i18n/told';
import { alarms, cell, markSeen } from '../state/cell';
import type { Alarm } from '../wire/types';
import { clockTime, placeIn } from '../ui/format';
import { Button, Empty } from '../ui/controls';
import { Dialog } from '../ui/Dialog';

/** All alarms, newest first, with cause and remedy. */
export function Alarms({ onClose }: { onClose: () => void }) {
  const seen = () => markSeen(() => true);
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
                <time>{clockTime(alarm.time)}</time> <code>{alarm.code}</code> {placeIn(cell.value?.folder ?? '', alarm.where)}
              </p>
              <What alarm={alarm} />
            </li>
          ))}
        </ul>
      )}
    </Dialog>
  );
}

function What({ alarm }: { alarm: Alarm }) {
  const told = problemWords(alarm);
  return (
    <>
      <p class="what">{told.text}</p>
      {told.detail && <p>{told.detail}</p>}
      {told.advice && (
        <p>
          <b>{t('alarms.do')}:</b> {told.advice}
        </p>
      )}
    </>
  );
}
