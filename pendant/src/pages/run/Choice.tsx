/**
 * Chooses what Start runs: the cell's program, or the one open on the Program page. Shows whether it has
 * unsaved changes.
 */
import { computed, signal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { t } from '../../i18n';
import { go } from '../../shell/route';
import { connected, mayProgram, status } from '../../state/cell';
import { Button, Segmented } from '../../ui/controls';
import * as doc from '../program/documents';
import { shortName } from './Now';

const asked = signal('');

/** The program open on the Program page; empty if no program is open, or if it cannot be started. */
const written = computed(() => {
  const kind = doc.files.value.find((each) => each.name === doc.fileName.value)?.kind;
  return doc.isProgram.value && kind !== 'plc' ? doc.fileName.value : '';
});
/** The same, if the cell has another program or none; else empty. */
const other = computed(() => {
  const it = status.value?.program;
  return it && doc.sameFile(it.file, written.value) ? '' : written.value;
});
const saved = computed(() => doc.base.value !== '');

/** The program that Start runs instead of the cell's program; empty: the cell's program. */
export const chosen = computed(() => {
  const wanted = !status.value?.program || asked.value === other.value;
  return wanted && saved.value ? other.value : '';
});

/** Shown above the keys while no program runs. */
export function Choice() {
  const it = status.value?.program;
  useEffect(() => {
    // Opens the file that was open before this page was loaded, so that it can be offered.
    if (connected.value && doc.fileName.peek() === '' && doc.chosenFile.peek() !== '') void doc.openSomething();
  }, [connected.value]);
  if (it && !it.ended && !it.ready) return null;
  const name = written.value;
  const both = it && other.value !== '' && saved.value;
  const unsaved = name !== '' && doc.dirty.value && (other.value === '' || chosen.value === name || !saved.value);
  if (!both && !unsaved) return null;
  return (
    <div class="run-choice">
      {both && (
        <>
          <p>{t('run.whichText', { name })}</p>
          <Segmented
            label={t('run.which')}
            value={chosen.value || 'own'}
            options={[
              { id: 'own', name: shortName(it.file) },
              { id: name, name },
            ]}
            onChange={(id) => (asked.value = id === 'own' ? '' : id)}
          />
        </>
      )}
      {unsaved && (
        <>
          <p role="status">{t(saved.value ? 'run.unsaved' : 'run.neverSaved', { name })}</p>
          <Button label={t('run.save', { name })} icon="save" disabled={!mayProgram.value} onClick={() => void save()} />
        </>
      )}
    </div>
  );
}

/** Saves the file. If another client has changed it, the Program page asks which version to keep. */
async function save(): Promise<void> {
  if (!(await doc.save()) && doc.theirs.peek()) go('program');
}
