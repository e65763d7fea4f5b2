/** The list of cells to open; saves a copy; downloads and restores a cell as a zip file. */
import { useEffect, useRef, useState } from 'preact/hooks';
import { t } from '../../i18n';
import { cell, complain, mayAdminister, request, status } from '../../state/cell';
import { toast } from '../../state/toasts';
import { open } from '../../ui/ask';
import { Button, Card, Empty, Field, Loading, Select } from '../../ui/controls';
import { Dialog } from '../../ui/Dialog';
import { Icon } from '../../ui/Icon';
import { Working } from './Overview';
import { ReachDialog, wantsMore } from './Reach';
import { restart, restarting } from './restart';

interface Project {
  name: string;
  folder: string;
  title: string;
  robots: string[];
  recent: boolean;
}

/** If copies have the same title, their names distinguish them. */
const titleOf = (project: Project, all: Project[]) =>
  project.title && all.some((each) => each !== project && each.title === project.title) ? `${project.title} (${project.name})` : project.title || project.name;

const goodName = (name: string) => /^[\w][\w-]{0,59}$/.test(name);

/** A project name for a file: `cell` for `cell (1).zip`, or `cell2` if `cell` exists. */
function nameFor(file: string, taken: string[]): string {
  const plain = file.replace(/\.zip$/i, '').replace(/\s*\(\d+\)$/, '').replace(/[^\w-]+/g, '_').replace(/^[-_]+/, '').slice(0, 50) || 'project';
  for (let i = 1; ; ++i) {
    const name = i === 1 ? plain : `${plain}${i}`;
    if (!taken.includes(name)) return name;
  }
}

export function Projects() {
  const [list, setList] = useState<Project[] | null>(null);
  const load = () =>
    request('cells').then(
      (answer) => setList(answer.cells),
      (error) => {
        complain(error);
        setList([]);
      },
    );
  useEffect(() => void load(), []);
  const begin = (project: Project) =>
    restart(t('cell.opening', { name: project.name }), t('cell.opened', { name: project.name }), 'cell.open', { folder: project.folder }).then(load);
  const openOne = (project: Project) =>
    open((close) => <ReachDialog folder={project.folder} name={titleOf(project, list ?? [])} onClose={close} onOpen={() => void begin(project)} />);
  const none = status.value?.state === 'no cell';
  return (
    <div class="cell-grid">
      <Card title={t('cell.thisCell')}>
        <div class="row">
          <a class={`button ${none ? 'off' : ''}`} aria-disabled={none || undefined} href={none ? undefined : '/api/project.zip'} download={`${cell.value?.name ?? 'cell'}.zip`}>
            <Icon name="download" size={22} />
            <span>{t('cell.backUp')}</span>
          </a>
          <Restore taken={(list ?? []).map((each) => each.name)} onDone={load} />
        </div>
        <div class="row">
          <Button label={t('cell.saveAs')} icon="copy" disabled={!mayAdminister.value || none} onClick={() => open((close) => <NameDialog kind="copy" onClose={close} onDone={load} />)} />
          <Button label={t('cell.new')} icon="plus" disabled={!mayAdminister.value || none} onClick={() => open((close) => <NameDialog kind="new" onClose={close} onDone={load} />)} />
        </div>
        <p class="note">{t('cell.backUpText')}</p>
      </Card>
      <Card title={t('cell.projects')} class="cell-wide">
        {restarting.value && <Working />}
        {list === null ? (
          <Loading />
        ) : list.length === 0 ? (
          <Empty icon="folder" text={t('cell.noProjects')} />
        ) : (
          <ul class="entries">
            {list.map((each) => {
              const here = !none && each.folder === cell.value?.folder;
              return (
                <li key={each.folder}>
                  <button type="button" aria-current={here ? 'true' : undefined} class={here ? 'here' : ''} disabled={here || !mayAdminister.value || restarting.value !== ''} onClick={() => openOne(each)}>
                    <Icon name="folder" />
                    <span>
                      <strong>{titleOf(each, list)}</strong>
                      <small>{[each.robots.join(', '), each.folder].filter(Boolean).join(' · ')}</small>
                    </span>
                    {each.recent && !here && <span class="chip">{t('cell.recent')}</span>}
                    {here && <span class="chip good">{t('cell.isOpen')}</span>}
                  </button>
                </li>
              );
            })}
          </ul>
        )}
      </Card>
    </div>
  );
}

/** `taken`: the names of the existing projects. */
function Restore({ taken, onDone }: { taken: string[]; onDone: () => void }) {
  const input = useRef<HTMLInputElement>(null);
  const choose = (from: HTMLInputElement) => {
    const file = from.files?.[0];
    from.value = ''; // so that the same file can be chosen again
    if (file) open((close) => <RestoreDialog file={file} taken={taken} onClose={close} onDone={onDone} />);
  };
  return (
    <>
      <input ref={input} type="file" accept=".zip,application/zip" hidden aria-label={t('cell.restore')} onChange={(e) => choose(e.currentTarget)} />
      <Button label={t('cell.restore')} icon="upload" disabled={!mayAdminister.value} onClick={() => input.current?.click()} />
    </>
  );
}

/**
 * Asks for the project name of a backup. The default is the file's name, with a number if a project has that
 * name.
 */
function RestoreDialog({ file, taken, onClose, onDone }: { file: File; taken: string[]; onClose: () => void; onDone: () => void }) {
  const [name, setName] = useState(() => nameFor(file.name, taken));
  const problem = name !== '' && !goodName(name) ? t('cell.badName') : taken.includes(name) ? t('cell.nameTaken') : '';
  const bad = name === '' || problem !== '' || !mayAdminister.value;
  const go = async () => {
    if (bad) return;
    onClose();
    try {
      const answer = await fetch(`/api/project.zip?name=${encodeURIComponent(name)}`, { method: 'PUT', body: file, credentials: 'same-origin' });
      if (!answer.ok) throw new Error((await answer.text()).slice(0, 300) || answer.statusText);
      const { folder } = (await answer.json()) as { folder: string };
      toast({ kind: 'ok', text: t('cell.restored', { name }), detail: folder });
      onDone();
      if (await wantsMore(folder)) open((close) => <ReachDialog folder={folder} name={name} onClose={close} />);
    } catch (error) {
      toast({ kind: 'error', text: t('cell.notRestored'), detail: String((error as Error).message) });
    }
  };
  return (
    <Dialog
      title={t('cell.restore')}
      onClose={onClose}
      actions={
        <>
          <Button label={t('dialog.cancel')} onClick={onClose} />
          <Button label={t('cell.restoreDo')} tone="primary" icon="upload" disabled={bad} onClick={() => void go()} />
        </>
      }
    >
      <p>{t('cell.restoreText', { file: file.name })}</p>
      <Field label={t('program.name')} value={name} problem={problem} onInput={setName} onEnter={() => void go()} />
    </Dialog>
  );
}

function NameDialog({ kind, onClose, onDone }: { kind: 'copy' | 'new'; onClose: () => void; onDone: () => void }) {
  const [name, setName] = useState('');
  const [robot, setRobot] = useState(cell.value?.robots[0]?.id ?? '');
  const problem = name !== '' && !goodName(name) ? t('cell.badName') : '';
  const bad = name === '' || problem !== '' || (kind === 'new' && !/.\/./.test(robot));
  const go = async () => {
    if (bad) return;
    onClose();
    try {
      const answer = await request(kind === 'copy' ? 'cell.save_as' : 'cell.new', kind === 'copy' ? { name } : { name, robot }, 20_000);
      toast({ kind: 'ok', text: t('cell.made', { name }), detail: answer.folder });
      onDone();
    } catch (error) {
      complain(error);
    }
  };
  const own = cell.value?.robots.map((each) => each.id) ?? [];
  return (
    <Dialog
      title={t(kind === 'copy' ? 'cell.saveAs' : 'cell.new')}
      onClose={onClose}
      actions={
        <>
          <Button label={t('dialog.cancel')} onClick={onClose} />
          <Button label={t('program.create')} tone="primary" disabled={bad} onClick={() => void go()} />
        </>
      }
    >
      <Field label={t('program.name')} value={name} placeholder="my_cell" problem={problem} onInput={setName} onEnter={() => void go()} />
      {kind === 'new' && own.length > 0 && <Select label={t('move.robot')} value={robot} options={own.map((id) => ({ id, name: id }))} onChange={setRobot} />}
      {kind === 'new' && <p class="note">{t('cell.newText')}</p>}
    </Dialog>
  );
}
