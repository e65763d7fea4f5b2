/** Starts and stops a recording of the cell, and shows its file, time and size. It goes on when the page is left. */
import { signal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { t } from '../../i18n';
import { plain } from '../../i18n/told';
import { able } from '../../state/abilities';
import { complain, connected, mayMove, request } from '../../state/cell';
import { toast } from '../../state/toasts';
import { Button } from '../../ui/controls';
import type { RecordFacts } from '../../wire/requests';
import { recordWords } from './recording';

const facts = signal<RecordFacts | null>(null);
const kLookMs = 1000;

async function look(): Promise<void> {
  if (!connected.peek() || !able('record')) return void (facts.value = null);
  const before = facts.peek();
  const now = await request('record').catch(() => null);  // no cell, or one that cannot record: the key is not shown
  if (facts.peek() !== before) return;  // a press was faster
  facts.value = now;
  if (before?.recording && now && !now.recording) tellEnd(now);
}

function tellEnd(now: RecordFacts): void {
  toast(now.problem ? { kind: 'error', text: t('plots.recordFailed'), detail: plain(now.problem) } : { kind: 'ok', text: recordWords(now), detail: now.file });
}

async function press(): Promise<void> {
  try {
    if (facts.peek()?.recording) {
      const done = await request('record.stop');
      facts.value = done;
      tellEnd(done);
    } else facts.value = await request('record.start');
  } catch (error) {
    complain(error);
  }
}

export function RecordKey() {
  useEffect(() => {
    void look();
    const timer = setInterval(() => void look(), kLookMs);
    return () => clearInterval(timer);
  }, [connected.value]);
  if (!connected.value || !facts.value) return null;
  const on = facts.value.recording;
  return <Button label={t(on ? 'plots.recordStop' : 'plots.record')} icon={on ? 'stop' : 'record'} tone={on ? 'warn' : 'plain'} disabled={!mayMove.value} onClick={() => void press()} />;
}

/** Shown while the cell is recorded. */
export function RecordNote() {
  if (!connected.value || !facts.value?.recording) return null;
  return (
    <p class="note plots-recording" role="status">
      {recordWords(facts.value)}
    </p>
  );
}
