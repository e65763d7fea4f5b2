import { t } from '../../i18n';
import { blockedWords } from '../../shell/blocked';
import { step } from '../../state/actions';
import { go } from '../../shell/route';
import { attempt, mayAdminister, pausing, status, ways } from '../../state/cell';
import { canBe } from '../../state/ways';
import { ask } from '../../ui/ask';
import { Button } from '../../ui/controls';
import { chosen } from './Choice';
import { shortName } from './Now';
import { readAgain, shownText } from './Text';

/**
 * Starts the program. A loaded program that is ready starts from its saved file; one that has ended, or was
 * chosen here, is loaded again.
 */
async function start(): Promise<void> {
  const it = status.peek()?.program;
  const name = chosen.peek() || it?.file;
  if (!name) return;
  const shown = shownText.peek();
  const hash = shown.hash && shown.file === shortName(name) ? shown.hash : undefined;
  const begun =
    chosen.peek() || !it?.ready
      ? await attempt('program.from', { program: name, confirmed: true, ...(hash && { hash }) })
      : await attempt('program.start', { as_saved: true, file: it.file, hash: it.hash, ...(hash && { saved: hash }) });
  if (!begun) ++readAgain.value;
}

/**
 * Start as one big key; while the program runs, a step key and a separate end key. Pause and Resume are in
 * the bar. The keys are other elements than Start, so a press that began on Start never becomes a press on
 * Step.
 */
export function Keys() {
  if (status.value?.state === 'no cell') return <WithoutCell />;
  const it = status.value?.program;
  const now = ways.value;
  if (now.going)
    return (
      <div key="goes" class="run-keys goes">
        <Button label={t(pausing.value ? 'state.pausing' : 'run.step')} icon="step" big disabled={!canBe(now.step)} onClick={() => void step()} />
        <EndKey />
      </div>
    );
  const nothing = !it && !chosen.value;
  const why = blockedWords(now.start);
  return (
    <div key="start" class="run-keys">
      <Button label={t('run.start')} icon="run" tone="good" big disabled={nothing || !canBe(now.start)} class="main" onClick={() => void start()} />
      {why && <p class="note">{why}</p>}
    </div>
  );
}

/** The cell could not be started: the same ways on as on the Cell page. */
function WithoutCell() {
  return (
    <div key="none" class="run-keys">
      <p class="note">{t('cell.noneOpenText')}</p>
      <Button label={t('cell.toProjects')} icon="folder" tone="primary" big onClick={() => go('cell')} />
      <Button label={t('cell.tryAgain')} icon="repeat" big disabled={!mayAdminister.value} onClick={() => void attempt('cell.restart')} />
    </div>
  );
}

export function EndKey() {
  const end = () =>
    ask({ title: `${t('run.stop')}?`, text: t('run.stopText'), action: t('run.stop'), tone: 'danger', onYes: () => void attempt('program.stop'), still: () => canBe(ways.value.end) });
  return <Button label={t('run.stop')} class="end-program" disabled={!canBe(ways.value.end)} onClick={end} />;
}
