/**
 * The panel beside the program: start, pause, step; the tasks with their lines and variables; the problems by
 * line.
 */
import type { Args, RequestName } from '../../state/cell';
import { useEffect } from 'preact/hooks';
import { number, t, word } from '../../i18n';
import { findingWords, ownWords } from '../../i18n/told';
import { attempt, complain, connected, mayMove, pausing, program, request, status, ways } from '../../state/cell';
import { step } from '../../state/actions';
import { canBe } from '../../state/ways';
import { blockedWords } from '../../shell/blocked';
import { lastCycle } from '../../state/cycle';
import { kept } from '../../state/settings';
import { open } from '../../ui/ask';
import { Button, Segmented } from '../../ui/controls';
import { Dialog } from '../../ui/Dialog';
import { duration, shortened } from '../../ui/format';
import { Icon } from '../../ui/Icon';
import { RobotView } from '../../view3d/RobotView';
import { EndKey } from '../run/Keys';
import { NoPass } from '../run/NoPass';
import { programWord } from '../run/Now';
import { BreakpointButton } from './CodeView';
import * as doc from './documents';
import { dry, dryRun, dryWords, forgetDry } from './dry';

const shown = kept<'problems' | 'variables' | 'view'>('program.panel', 'problems');

export function RunPanel() {
  const file = doc.fileName.value;
  // The paths of a dry run belong to its file.
  useEffect(() => {
    const now = dry.peek();
    if (now.kind === 'done' && now.file !== file) forgetDry();
  }, [file]);
  return (
    <aside class="program-side" aria-label={t('program.runAndLook')}>
      <Where />
      <NoPass />
      <Buttons />
      <Segmented
        label={t('program.panel')}
        value={shown.value}
        options={[
          { id: 'problems', name: t('program.problems') },
          { id: 'variables', name: t('program.variables') },
          { id: 'view', name: t('program.view') },
        ]}
        onChange={(id) => (shown.value = id)}
      />
      <div class={`program-panel shows-${shown.value}`}>{shown.value === 'problems' ? <Problems /> : shown.value === 'variables' ? <Tasks /> : <RobotView />}</div>
    </aside>
  );
}

function Where() {
  const now = status.value?.program;
  if (!now || now.ready) return <p class="program-where off">{t('program.notBegun')}</p>;
  const { text: state, tone } = programWord();
  return (
    <div class={`program-where ${tone} ${now.state}`} role="status">
      <strong>{state}</strong>
      <span>{t('program.whereIs', { file: shortName(now.lineFile || now.file), line: now.line })}</span>
      <dl>
        <div>
          <dt>{t('program.passes')}</dt>
          <dd>{now.passes}</dd>
        </div>
        <div>
          <dt>{t('program.cycle')}</dt>
          <dd>{Number.isFinite(lastCycle.value ?? NaN) ? duration(lastCycle.value!) : '–'}</dd>
        </div>
      </dl>
    </div>
  );
}

const shortName = (file: string) => file.slice(file.lastIndexOf('/') + 1);

function Buttons() {
  const now = ways.value;
  const line = doc.atLine.value;
  const open = doc.fileName.value !== '' && doc.isProgram.value;
  if (!now.going) {
    const wrong = doc.errors.value > 0;
    const why = blockedWords(now.start) || (!open ? t('why.noneOpen') : wrong ? t('program.startErrors') : '');
    return (
      <div key="start" class="program-buttons">
        <Button label={t('program.start')} icon="run" big tone="good" disabled={!open || !canBe(now.start) || wrong} onClick={() => void doc.start()} />
        <Button label={t('program.dry')} icon="eye" big disabled={!connected.value || !doc.isProgram.value || dry.value.kind === 'runs'} onClick={beginDry} />
        <Button label={t('program.fromLine', { line })} icon="right" disabled={!open || !canBe(now.start) || wrong} onClick={() => void runFrom(line)} />
        <BreakpointButton />
        {why && <p class="note">{why}</p>}
      </div>
    );
  }
  return (
    <div key="goes" class="program-buttons">
      <Button label={t(pausing.value ? 'state.pausing' : 'program.stepOver')} icon="step" big disabled={!canBe(now.step)} title={blockedWords(now.step) || undefined} onClick={() => void step()} />
      <Button label={t('program.stepInto')} icon="down" disabled={!canBe(now.stepInto)} title={blockedWords(now.stepInto) || undefined} onClick={() => void step('into')} />
      <Button label={t('program.stepOut')} icon="up" disabled={!canBe(now.stepInto)} title={blockedWords(now.stepInto) || undefined} onClick={() => void step('out')} />
      <Button label={t('program.fromLine', { line })} icon="right" disabled={!open || !canBe(now.stepInto)} onClick={() => void runFrom(line)} />
      <BreakpointButton />
      <EndKey />
      {blockedWords(now.stepInto) && <p class="note">{blockedWords(now.stepInto)}</p>}
    </div>
  );
}

/** For requests whose answer comes when the robot is at standstill. No timeout. */
async function longAttempt<Name extends RequestName>(name: Name, args: Args<Name>): Promise<void> {
  await request<RequestName>(name, args, 0).catch(complain);
}

function beginDry(): void {
  shown.value = 'problems';
  void dryRun(doc.fileName.value, doc.text.value);
}

// --- start at a line

interface Assumed {
  where: { file: string; line: number };
  source: string;
  robot: string;
  tool: string;
  frame: string;
  last_point: string;
  sets: { name: string; value: string }[];
  reads: { name: string; value: string }[];
  variables: { name: string; value: string }[];
  held: string[];
}

export async function runFrom(line: number): Promise<void> {
  if (doc.dirty.value && !(await doc.save())) return;
  try {
    const assumed = await request('program.from', { program: doc.fileName.value, line, ...doc.shownHash() });
    open((close) => <FromDialog assumed={assumed} onClose={close} />);
  } catch (error) {
    complain(error);
  }
}

function FromDialog({ assumed, onClose }: { assumed: Assumed; onClose: () => void }) {
  const no = () => {
    onClose();
    void longAttempt('program.stop', {});
  };
  const rows: [string, string][] = [
    [t('program.aRobot'), assumed.robot],
    [t('program.aTool'), assumed.tool],
    [t('program.aFrame'), assumed.frame],
    [t('program.aPoint'), assumed.last_point],
    [t('program.aHeld'), assumed.held.join(', ')],
  ];
  return (
    <Dialog
      title={t('program.fromTitle', { line: assumed.where.line })}
      onClose={no}
      actions={
        <>
          <Button label={t('dialog.cancel')} onClick={no} />
          <Button label={t('program.fromDo', { line: assumed.where.line })} icon="run" tone="good" disabled={!mayMove.value} onClick={() => (onClose(), void attempt('program.go'))} />
        </>
      }
    >
      <pre class="program-source">{assumed.source}</pre>
      <p>{t('program.fromText')}</p>
      <dl class="program-assumed">
        {rows.map(([name, value]) => (
          <div key={name}>
            <dt>{name}</dt>
            <dd>{value || t('program.aNone')}</dd>
          </div>
        ))}
        <Values title={t('program.aReads')} values={assumed.reads} />
        <Values title={t('program.aSets')} values={assumed.sets} />
        <Values title={t('program.variables')} values={assumed.variables} />
      </dl>
    </Dialog>
  );
}

function Values({ title, values }: { title: string; values: { name: string; value: string }[] }) {
  if (!values || values.length === 0) return null;
  return (
    <div>
      <dt>{title}</dt>
      <dd>
        {values.map((each) => (
          <code key={each.name}>
            {each.name} = {shortened(each.value)}
          </code>
        ))}
      </dd>
    </div>
  );
}

// --- problems

function Problems() {
  const now = dry.value;
  const stale = now.kind === 'done' && (now.file !== doc.fileName.value || now.text !== doc.text.value);
  const found = now.kind === 'done' && !stale ? now.result.problems : [];
  const checked = [...doc.problems.value, ...doc.elsewhere.value];
  const list = [...checked, ...found.filter((each) => !checked.some((one) => one.line === each.line && one.what === each.what))];
  return (
    <>
      {now.kind === 'runs' && (
        <div class="program-dry" role="status">
          <span class="spinner" aria-hidden="true" />
          <span class="grow">{t('program.dryRuns', { moves: now.moves, line: now.line })}</span>
          <Button label={t('dialog.cancel')} onClick={now.stop} />
        </div>
      )}
      {now.kind === 'done' && <DryAnswer stale={stale} />}
      {list.length === 0 && now.kind !== 'runs' && <Checked />}
      <ul class="program-problems">
        {[...list].sort((a, b) => a.line - b.line).map((each, i) => {
          const { text, detail, advice } = findingWords(each);
          return (
          <li key={i}>
            <button type="button" class={each.severity} onClick={() => void goTo(each.line, each.file)}>
              <Icon name="alarm" size={20} />
              <span>
                <small>
                  {placeText(each)} · {t(each.severity === 'error' ? 'program.error' : 'program.warning')}
                </small>
                <strong>{text}</strong>
                {detail && <span>{detail}</span>}
                {advice && <span>{advice}</span>}
              </span>
            </button>
          </li>
          );
        })}
      </ul>
    </>
  );
}

/** Says that the program is correct only after a check. */
function Checked() {
  if (doc.fileName.value === '') return null;
  if (!doc.isProgram.value)
    return (
      <div class="program-note">
        <p>{t('program.notChecked')}</p>
        <a href="#/cell">{t('program.toCell')}</a>
      </div>
    );
  if (!doc.checked.value) return <p class="program-note">{t('program.beingChecked')}</p>;
  return (
    <p class="program-fine">
      <Icon name="check" size={20} /> {t('program.noProblems')}
    </p>
  );
}

const isHere = (file: string) => file === '' || doc.sameFile(file, doc.fileName.value);

function placeText({ file, line }: { file: string; line: number }): string {
  return isHere(file) ? t('program.line', { line }) : t('program.whereIs', { file: shortName(file), line });
}

/** Shows a line of the open file, or of another file of the cell, which it opens. */
export async function goTo(line: number, file = ''): Promise<void> {
  const other = isHere(file) ? undefined : doc.files.value.find((each) => doc.sameFile(each.name, file))?.name;
  if (!isHere(file) && (other === undefined || !(await doc.openFile(other)))) return;
  doc.atLine.value = line;
  doc.wantedLine.value = line;
}

function DryAnswer({ stale }: { stale: boolean }) {
  const now = dry.value;
  if (now.kind !== 'done') return null;
  const { result } = now;
  const { title, until, unchecked } = dryWords(result);
  const good = title === 'program.dryGood';
  return (
    <div class={`program-dry ${stale ? 'stale' : good ? 'good' : 'bad'}`} role="status">
      <Icon name={good ? 'check' : 'alarm'} />
      <span class="grow">
        <strong>{t(stale ? 'program.dryStale' : title)}</strong>
        <small>
          {t('program.dryMoves', { moves: result.moves })}
          {result.seconds !== null && result.seconds !== undefined && ` · ${t('program.dryTime', { time: `${number(result.seconds, 1)} s` })}`}
          {result.reached && ` · ${t('program.dryReached', { line: result.reached.line })}`}
          {until !== null && ` · ${t('program.dryUntil', { time: `${number(until, 1)} s` })}`}
          {unchecked && ` · ${unchecked}`}
        </small>
      </span>
      {result.paths.length > 0 && <Button label={t('program.dryShow')} icon="cube" bare tone="quiet" onClick={() => (shown.value = 'view')} />}
      <Button label={t('dialog.close')} icon="close" bare tone="quiet" onClick={forgetDry} />
    </div>
  );
}

// --- tasks and variables

interface TaskNow {
  name: string;
  state: string;
  where: { file: string; line: number };
  source: string;
  waits_for: string;
  text: string;
  paused: boolean;
  calls: { file: string; line: number }[];
  variables: { name: string; value: string }[];
  robot: string;
  tool: string;
  frame: string;
  problem?: string;
}

function Tasks() {
  const all = (program.value?.tasks as TaskNow[] | undefined) ?? [];
  const tasks = [...all].sort((a, b) => Number(doc.goesOn(b)) - Number(doc.goesOn(a)));
  if (tasks.length === 0) return <p class="program-note">{t('program.noTasks')}</p>;
  return (
    <>
      {tasks.map((task) => (
        <section key={task.name} class="program-task" aria-label={t('program.task', { name: task.name })}>
          <header>
            <h3>{task.name}</h3>
            <span class="chip">{task.paused ? t('state.programPaused') : word('program.state', task.state)}</span>
          </header>
          <button type="button" class="program-source" onClick={() => void goTo(task.where.line, task.where.file)}>
            <small>
              {shortName(task.where.file)}:{task.where.line}
            </small>
            <code>{task.source}</code>
          </button>
          {task.waits_for && (
            <p class="note">
              {t('program.waitsFor')} {word('wait', task.waits_for)}{task.text && `: ${task.text}`}
            </p>
          )}
          {task.problem && <p class="program-failed">{ownWords(task.problem)}</p>}
          {(task.tool || task.frame || task.robot) && (
            <p class="note">{[task.robot, task.tool, task.frame].filter(Boolean).join(' · ')}</p>
          )}
          {task.variables.length > 0 && (
            <table class="plain program-variables">
              <tbody>
                {task.variables.map((each) => (
                  <tr key={each.name}>
                    <th scope="row">{each.name}</th>
                    <td>
                      <code>{shortened(each.value)}</code>
                    </td>
                  </tr>
                ))}
              </tbody>
            </table>
          )}
        </section>
      ))}
    </>
  );
}
