/** Reports that another program has changed the data files, and loads the changes when the user agrees. */
import { signal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { t } from '../../i18n';
import { able } from '../../state/abilities';
import { connected, mayProgram, request } from '../../state/cell';
import { changePoints } from '../../state/points';
import { toast } from '../../state/toasts';
import { Button } from '../../ui/controls';
import { Icon } from '../../ui/Icon';

interface Changed {
  file: string;
  changed: string[];
  added: string[];
  removed: string[];
}
const kLookMs = 3000;
const found = signal<Changed[]>([]);

async function look(): Promise<void> {
  if (!connected.peek() || !able('points.outside')) return;
  found.value = await request('points.outside').then(
    (answer) => answer.files,
    () => [],
  );
}

async function take(): Promise<void> {
  const files = found.peek().map((each) => each.file).join(', ');
  if (!(await changePoints('points.take', {}))) return;
  found.value = [];
  toast({ kind: 'ok', text: t('points.outsideTaken', { files }) });
}

export function Outside() {
  useEffect(() => {
    void look();
    const timer = setInterval(() => void look(), kLookMs);
    return () => clearInterval(timer);
  }, []);
  if (found.value.length === 0) return null;
  const names = (list: 'changed' | 'added' | 'removed') => found.value.flatMap((each) => each[list]).join(', ');
  return (
    <div class="banner" role="status">
      <Icon name="alarm" />
      <div>
        <strong>{t('points.outside', { files: found.value.map((each) => each.file).join(', ') })}</strong>
        <p>
          {(['changed', 'added', 'removed'] as const)
            .filter((list) => names(list) !== '')
            .map((list) => t(`points.outside.${list}`, { names: names(list) }))
            .join(' ')}
        </p>
      </div>
      <Button label={t('points.outsideTake')} icon="download" disabled={!mayProgram.value} onClick={() => void take()} />
    </div>
  );
}
