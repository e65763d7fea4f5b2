import { t } from '../../i18n';
import { resume } from '../../state/actions';
import { attempt, mayMove, status } from '../../state/cell';
import { ask } from '../../ui/ask';
import { Button } from '../../ui/controls';
import { chosen } from './Choice';

/** One that stands ready begins, as its file is now; one that has ended, or was chosen here, anew from its file. */
function start(): void {
  const it = status.peek()?.program;
  const other = chosen.peek();
  if (other) void attempt('program.from', { program: other, confirmed: true });
  else if (it?.ready) void attempt('program.start', { as_saved: true });
  else if (it) void attempt('program.from', { program: it.file, confirmed: true });
}

/** Start, or pause and go on, in one big key; step and end beside it. */
export function Keys() {
  const now = status.value;
  const it = now?.program;
  const disabled = !mayMove.value || (!it && !chosen.value) || now?.state === 'fault';
  const ended = it ? it.ended || it.ready : true;
  const paused = it?.paused ?? false;
  const held = now?.state === 'held';
  const end = () =>
    ask({ title: `${t('run.stop')}?`, text: t('run.stopText'), action: t('run.stop'), tone: 'danger', onYes: () => void attempt('program.stop') });
  return (
    <div class="run-keys">
      <Button {...mainKey(ended, paused, held)} big disabled={disabled} class="main" />
      <Button
        label={t('run.step')}
        icon="step"
        big
        disabled={disabled || ended || held || !paused}
        onClick={() => void attempt('program.step', { how: 'over' })}
      />
      <Button label={t('run.stop')} icon="stop" big disabled={disabled || ended} onClick={end} />
    </div>
  );
}

function mainKey(ended: boolean, paused: boolean, held: boolean) {
  if (ended)
    return { label: t('run.start'), icon: 'run', tone: 'good', onClick: start } as const;
  if (held) return { label: t('bar.resume'), icon: 'run', tone: 'good', onClick: () => void resume() } as const;
  if (paused)
    return { label: t('run.continue'), icon: 'run', tone: 'good', onClick: () => void attempt('program.go') } as const;
  return { label: t('run.pause'), icon: 'pause', tone: 'plain', onClick: () => void attempt('program.pause') } as const;
}
