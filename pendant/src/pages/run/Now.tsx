import { t, word } from '../../i18n';
import { plain, problemWords } from '../../i18n/told';
import { isByPerson, pausing, program, status } from '../../state/cell';
import type { Json } from '../../wire/connection';
import { sameFile } from '../program/sameFile';
import { NoPass } from './NoPass';

/** A program's name without its folder. */
export function shortName(file: string): string {
  return file.split('/').pop() ?? file;
}

export function programWord(): { text: string; tone: string } {
  const now = status.value;
  const it = now?.program;
  if (!it) return { text: t(!now ? 'why.offline' : now.state === 'no cell' ? 'why.noCell' : 'run.none'), tone: 'off' };
  if (now.state === 'fault') return { text: t('state.fault'), tone: 'bad' };
  if (it.ready) return { text: t('program.ready'), tone: 'off' };
  if (it.ended && wasCanceled()) return { text: t('program.canceled'), tone: 'off' };
  if (it.ended) return { text: word('program', it.state), tone: it.state === 'failed' ? 'bad' : 'off' };
  if (!now.simulated && !now.armed) return { text: t('program.notArmed'), tone: 'warn' };
  if (now.state === 'held' || now.state === 'stopping') return { text: t('program.held'), tone: 'warn' };
  if (pausing.value) return { text: t('state.pausing'), tone: 'warn' };
  if (it.paused) return { text: t('program.paused'), tone: 'warn' };
  return { text: now.moving ? t('program.running') : word('program', it.state), tone: 'busy' };
}

/** The line, and its file if it is not that of the program. */
function lineText(line: number, file = ''): string {
  const own = status.value?.program?.file ?? '';
  return file === '' || sameFile(file, own) ? t('run.line', { line }) : t('run.lineOf', { line, file: shortName(file) });
}

/** The program's name and state, and the current statement, or those of several tasks. */
export function Now() {
  const it = status.value?.program;
  const state = programWord();
  if (!it) return <p class="run-now off">{state.text}</p>;
  return (
    <div class={`run-now ${state.tone}`}>
      <header>
        <h2 title={it.file}>{shortName(it.file)}</h2>
        <span class={`chip ${state.tone === 'bad' ? 'bad' : state.tone === 'warn' ? 'warn' : ''}`} role="status">
          {state.text}
        </span>
      </header>
      {!it.ended && !it.ready && (
        <>
          {tasksNow().length < 2 && (
            <p class="statement">
              <span class="line">{lineText(it.line, it.lineFile)}</span>
              <code title={it.source}>{it.source || '…'}</code>
            </p>
          )}
          <Tasks />
        </>
      )}
      {it.ended && it.problem && (
        <p class={wasCanceled() ? 'note' : 'problem-text'}>
          <b>{t('run.problem')}:</b> {whyEnded(it.problem)}
        </p>
      )}
      <NoPass />
    </div>
  );
}

/** True if a person cancelled the motion that the program waited for. */
const wasCanceled = () => isByPerson((program.value?.problem as { code?: string } | null | undefined)?.code ?? '');

/** Why the program ended, in the page's language if its code is known. */
function whyEnded(told: string): string {
  const problem = (program.value as Json | null)?.problem as { code: string; what: string } | null | undefined;
  if (!problem?.code) return plain(told);
  const { text, detail } = problemWords(problem);
  return detail ? `${text} (${detail})` : text;
}

interface TaskLine {
  name: string;
  state: string;
  where?: { file?: string; line?: number };
  source: string;
  waits_for: string;
  text?: string;
  paused: boolean;
}

const tasksNow = () => ((program.value as Json | null)?.tasks ?? []) as TaskLine[];

function waits(task: TaskLine): string {
  if (task.paused) return t('program.paused');
  // A held or faulted cell waits for a person, whatever its program waits for.
  if (!task.waits_for || status.value?.state !== 'running') return '';
  const what = word('wait', task.waits_for);
  return t('run.waitsFor', { what: task.waits_for === 'link' ? `${what} ${task.text ?? ''}` : what });
}

/** What the task waits for. With several tasks, one line for each. */
function Tasks() {
  const tasks = tasksNow();
  const going = tasks.filter((task) => task.state === 'running' || task.state === 'waiting');
  if (tasks.length < 2) return <p class="note">{tasks[0] ? waits(tasks[0]) : ' '}</p>;
  return (
    <ul class="run-tasks" aria-label={t('run.tasks')}>
      {going.map((task) => (
        <li key={task.name}>
          <b>{task.name}</b>
          <code>{task.source}</code>
          <small>
            {lineText(task.where?.line ?? 0, task.where?.file)}
            {waits(task) && ` · ${waits(task)}`}
          </small>
        </li>
      ))}
    </ul>
  );
}
