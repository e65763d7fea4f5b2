/** File operations: open, new, save as, rename, delete; and earlier versions. */
import { useEffect, useMemo, useState } from 'preact/hooks';
import { moment, t } from '../../i18n';
import { attempt, complain, mayProgram, request } from '../../state/cell';
import { ask, open } from '../../ui/ask';
import { Button, Empty, Field, Loading, Segmented } from '../../ui/controls';
import { Dialog } from '../../ui/Dialog';
import { Icon } from '../../ui/Icon';
import { SideBySide } from './Conflict';
import { diff } from './diff';
import * as doc from './documents';

export function FilesDialog({ onClose }: { onClose: () => void }) {
  const [all, setAll] = useState(false);
  useEffect(() => void doc.loadFiles(), []);
  const list = all ? doc.files.value : doc.programFiles.value;
  return (
    <Dialog
      title={t('program.files')}
      wide
      onClose={onClose}
      actions={
        <>
          <Button label={t('program.rename')} icon="edit" disabled={!mayProgram.value || doc.base.value === ''} onClick={() => open((close) => <RenameDialog onClose={close} />)} />
          <Button label={t('program.delete')} icon="trash" disabled={!mayProgram.value || doc.fileName.value === ''} onClick={askDelete} />
          <Button label={t('program.saveAs')} icon="copy" disabled={!mayProgram.value || doc.fileName.value === ''} onClick={() => open((close) => <SaveAsDialog onClose={close} />)} />
          <Button label={t('program.new')} icon="plus" tone="primary" onClick={() => open((close) => <NewFileDialog onClose={close} />)} />
        </>
      }
    >
      <Segmented
        label={t('program.whichFiles')}
        value={all ? 'all' : 'programs'}
        options={[
          { id: 'programs', name: t('program.onlyPrograms') },
          { id: 'all', name: t('program.allFiles') },
        ]}
        onChange={(id) => setAll(id === 'all')}
      />
      <ul class="entries">
        {list.map((each) => (
          <li key={each.name}>
            <button
              type="button"
              class={each.name === doc.fileName.value ? 'here' : ''}
              aria-current={each.name === doc.fileName.value ? 'true' : undefined}
              onClick={() => (onClose(), void doc.openFile(each.name))}
            >
              <Icon name="program" />
              <span>
                <strong>{each.name}</strong>
                <small>
                  {[t(kindKey(each.kind)), moment(each.modified_s)].join(' · ')}
                </small>
              </span>
              {each.name === doc.mainFile.value && <span class="chip">{t('program.main')}</span>}
              {each.draft && <span class="chip warn">{t('program.stateDraft')}</span>}
              {each.running && <span class="chip good">{t('state.programRuns')}</span>}
            </button>
          </li>
        ))}
      </ul>
    </Dialog>
  );
}

function kindKey(kind: string) {
  const known = {
    program: 'program.kindProgram', plc: 'program.kindPlc', data: 'program.kindData', points: 'program.kindPoints',
    signals: 'program.kindSignals', scene: 'program.kindScene', cell: 'program.kindCell', test: 'program.kindTest',
  } as const;
  return known[kind as keyof typeof known] ?? 'program.kindText';
}

function askDelete(): void {
  const name = doc.fileName.value;
  ask({
    title: t('program.deleteQ', { name }),
    text: t('program.deleteText'),
    action: t('program.delete'),
    tone: 'danger',
    onYes: () => {
      const gone = doc.base.value === '' ? request('files.draft', { name }) : request('files.delete', { name });
      gone.then(() => doc.closeDeleted(name), complain);
    },
  });
}

const withEnding = (name: string) => (/\.\w+$/.test(name.trim()) ? name.trim() : `${name.trim()}.script`);
function nameProblem(name: string): string {
  if (name.trim() === '') return '';
  if (!/^[\w][\w .\-/]*$/.test(name.trim()) || name.includes('..')) return t('program.badName');
  if (doc.files.value.some((each) => each.name === withEnding(name))) return t('program.nameTaken');
  return '';
}

function NameDialog(props: { title: string; action: string; first: string; onClose: () => void; onName: (name: string) => void }) {
  const [name, setName] = useState(props.first);
  const problem = name === props.first && props.first !== '' ? '' : nameProblem(name);
  const bad = name.trim() === '' || problem !== '' || withEnding(name) === doc.fileName.value;
  const done = () => {
    if (bad) return;
    props.onClose();
    props.onName(withEnding(name));
  };
  return (
    <Dialog
      title={props.title}
      onClose={props.onClose}
      actions={
        <>
          <Button label={t('dialog.cancel')} onClick={props.onClose} />
          <Button label={props.action} tone="primary" disabled={bad} onClick={done} />
        </>
      }
    >
      <Field label={t('program.name')} value={name} placeholder="job.script" problem={problem} onInput={setName} onEnter={done} />
    </Dialog>
  );
}

export function NewFileDialog({ onClose }: { onClose: () => void }) {
  return (
    <NameDialog title={t('program.new')} action={t('program.create')} first="" onClose={onClose} onName={(name) => doc.newFile(name, '')} />
  );
}
function SaveAsDialog({ onClose }: { onClose: () => void }) {
  return <NameDialog title={t('program.saveAs')} action={t('program.save')} first="" onClose={onClose} onName={(name) => void doc.saveAs(name)} />;
}
function RenameDialog({ onClose }: { onClose: () => void }) {
  const name = doc.fileName.value;
  const rename = async (to: string) => {
    if (!(await attempt('files.rename', { name, to }))) return;
    await doc.loadFiles();
    await doc.openFile(to);
  };
  return <NameDialog title={t('program.rename')} action={t('program.rename')} first={name} onClose={onClose} onName={(to) => void rename(to)} />;
}

interface Version {
  number: number;
  when: string;
  what: string;
  bytes: number;
}

export function VersionsDialog({ onClose }: { onClose: () => void }) {
  const name = doc.fileName.value;
  const [list, setList] = useState<Version[] | null>(null);
  const [chosen, setChosen] = useState<{ version: Version; text: string } | null>(null);
  const look = (version: Version) =>
    request('files.version', { name, number: version.number }).then((answer) => setChosen({ version, text: answer.text }), complain);
  useEffect(() => {
    request('files.versions', { name }).then(
      (answer) => {
        setList(answer.versions);
        if (answer.versions[0]) void look(answer.versions[0]);
      },
      (error) => {
        complain(error);
        setList([]);
      },
    );
  }, []);
  const hunks = useMemo(() => (chosen ? diff(chosen.text, doc.text.value) : []), [chosen]);
  const same = hunks.every((each) => each.same);
  return (
    <Dialog
      title={t('program.versionsOf', { name })}
      wide
      onClose={onClose}
      actions={
        chosen && !same ? (
          <Button label={t('program.restore')} icon="undo" tone="primary" onClick={() => (onClose(), doc.change(chosen.text))} />
        ) : undefined
      }
    >
      {list === null ? (
        <Loading />
      ) : list.length === 0 ? (
        <Empty icon="clock" text={t('program.noVersions')} />
      ) : (
        <div class="program-versions">
          <ul>
            {list.map((each) => (
              <li key={each.number}>
                <Button label={t('program.versionUntil', { when: each.when })} pressed={chosen?.version.number === each.number} title={each.what} onClick={() => void look(each)} />
              </li>
            ))}
          </ul>
          {chosen &&
            (same ? (
              <p>{t('program.sameText')}</p>
            ) : (
              <SideBySide hunks={hunks} titles={[t('program.versionUntil', { when: chosen.version.when }), t('program.now')]} />
            ))}
        </div>
      )}
    </Dialog>
  );
}
