/**
 * Explains why a started program has ended at once: the condition of its loop was false, and what it needs.
 */
import { useEffect, useState } from 'preact/hooks';
import { t } from '../../i18n';
import { complain, mayAdminister, request, status } from '../../state/cell';
import { Button } from '../../ui/controls';
import { Icon } from '../../ui/Icon';
import { askReset, restarting } from '../cell/restart';
import { outermostLoop, type Loop } from './loop';
import { shortName } from './Now';

/** Shown if the program has finished without a pass of its outermost loop. */
export function NoPass() {
  const it = status.value?.program;
  const file = it && it.state === 'finished' && it.passes === 0 ? shortName(it.file) : '';
  const [loop, setLoop] = useState<Loop | null>(null);
  useEffect(() => {
    setLoop(null);
    if (!file) return;
    let gone = false;
    request('files.read', { name: file }).then((got) => gone || setLoop(outermostLoop(got.text)), complain);
    return () => void (gone = true);
  }, [file]);
  if (!file || !loop) return null;
  return (
    <div class="banner" role="status">
      <Icon name="alarm" />
      <div>
        <strong>{t('run.noPass', { loop: loop.source, line: loop.line })}</strong>
        <p>{t('run.noPassText')}</p>
        <Button label={t('cell.reset')} icon="undo" disabled={!mayAdminister.value || restarting.value !== ''} onClick={askReset} />
      </div>
    </div>
  );
}
