/** Alarms with cause and remedy, and the log with a filter. */
import { signal } from '@preact/signals';
import { useEffect, useRef } from 'preact/hooks';
import { t, word } from '../../i18n';
import { lineWords, problemWords } from '../../i18n/told';
import { alarms, cell, log, markSeen } from '../../state/cell';
import { kept } from '../../state/settings';
import type { LogLine } from '../../wire/types';
import { Button, Empty, Search, Segmented } from '../../ui/controls';
import { clockTime, placeIn } from '../../ui/format';
import { Icon } from '../../ui/Icon';

export function AlarmList() {
  const list = [...alarms.value].reverse();
  const seen = () => markSeen(() => true);
  if (list.length === 0) return <Empty icon="check" text={t('alarms.none')} />;
  return (
    <>
      {list.some((each) => !each.seen) && (
        <div class="row">
          <Button label={t('alarms.seen')} icon="check" onClick={seen} />
        </div>
      )}
      <ul class="health-alarms">
        {list.map((alarm, i) => (
          <li key={list.length - i} class={`${alarm.severity} ${alarm.seen ? 'seen' : ''}`}>
            <Icon name="alarm" size={26} />
            <div>
              <p class="note">
                <time>{clockTime(alarm.time)}</time> · <code>{alarm.code}</code>
              </p>
              <h3>{problemWords(alarm).text}</h3>
              {problemWords(alarm).detail && <p>{problemWords(alarm).detail}</p>}
              {alarm.where && (
                <p>
                  <b>{t('health.where')}:</b> {placeIn(cell.value?.folder ?? '', alarm.where)}
                </p>
              )}
              {problemWords(alarm).advice && (
                <p>
                  <b>{t('alarms.do')}:</b> {problemWords(alarm).advice}
                </p>
              )}
            </div>
          </li>
        ))}
      </ul>
    </>
  );
}

type Level = 'all' | 'warning' | 'error' | 'log';
const words = signal('');
const level = kept<Level>('health.level', 'all');

/** The log lines of that level (`warning` includes errors) that contain every word of the filter. */
export function filterLog(lines: LogLine[], which: Level, text: string): LogLine[] {
  const wanted = text.toLowerCase().split(/\s+/).filter(Boolean);
  return lines.filter((line) => {
    if (which === 'error' && line.level !== 'error') return false;
    if (which === 'warning' && line.level !== 'error' && line.level !== 'warning') return false;
    if (which === 'log' && line.level !== 'log') return false;
    const here = lineWords(line).toLowerCase();
    return wanted.every((one) => here.includes(one));
  });
}

const kShown = 500;

export function LogList() {
  const list = filterLog(log.value, level.value, words.value);
  const box = useRef<HTMLOListElement>(null);
  const atEnd = useRef(true);
  useEffect(() => {
    if (box.current && atEnd.current) box.current.scrollTop = box.current.scrollHeight;
  }, [list.length, list[list.length - 1]]);
  const save = () => {
    const text = list.map((line) => `${clockTime(line.time)} ${line.level} ${lineWords(line)}`).join('\n');
    const url = URL.createObjectURL(new Blob([text], { type: 'text/plain' }));
    const link = document.createElement('a');
    link.href = url;
    link.download = 'polyarm.log';
    link.click();
    setTimeout(() => URL.revokeObjectURL(url), 1000);
  };
  return (
    <>
      <div class="health-filter">
        <Search class="health-search" label={t('health.searchLog')} value={words.value} onInput={(text) => (words.value = text)} />
        <Segmented<Level>
          label={t('health.level')}
          value={level.value}
          options={[
            { id: 'all', name: t('health.all') },
            { id: 'log', name: t('health.ofProgram') },
            { id: 'warning', name: t('health.warnings') },
            { id: 'error', name: t('health.errors') },
          ]}
          onChange={(id) => (level.value = id)}
        />
        <Button label={t('health.saveLog')} icon="download" bare disabled={list.length === 0} onClick={save} />
      </div>
      {list.length === 0 ? (
        <Empty icon="edit" text={log.value.length ? t('health.noLine') : t('health.noLog')} />
      ) : (
        <ol
          class="health-log"
          ref={box}
          tabIndex={0}
          aria-label={t('health.log')}
          onScroll={(e) => {
            const at = e.currentTarget;
            atEnd.current = at.scrollHeight - at.scrollTop - at.clientHeight < 40;
          }}
        >
          {list.slice(-kShown).map((line, i) => (
            <li key={line.number ?? i} class={line.level}>
              <time>{clockTime(line.time)}</time>
              <span class="level">{word('health.l', line.level)}</span>
              <span>{lineWords(line)}</span>
            </li>
          ))}
        </ol>
      )}
    </>
  );
}
