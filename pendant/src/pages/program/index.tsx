/** The Program page: a program as text and as steps; editing, checking, running, and watching it run. */
import { useEffect } from 'preact/hooks';
import { t } from '../../i18n';
import { WatchOnly } from '../../shell/Control';
import { mayProgram } from '../../state/cell';
import { followPoints } from '../../state/points';
import { kept } from '../../state/settings';
import { open } from '../../ui/ask';
import { Button, Empty, Segmented } from '../../ui/controls';
import { Icon } from '../../ui/Icon';
import { CodeView } from './CodeView';
import { ConflictNotice, DraftNotice, RunningNotice } from './Conflict';
import * as doc from './documents';
import { FilesDialog, NewFileDialog, VersionsDialog } from './Files';
import './program.css';
import { RunPanel } from './RunPanel';
import { StepsView } from './StepsView';
import { loadWords } from './words';

const view = kept<'text' | 'steps'>('program.view', matchMedia('(pointer: coarse)').matches ? 'steps' : 'text');
/** A narrow screen shows only one of the two sides. */
const side = kept<'program' | 'run'>('program.side', 'program');

export default function Page() {
  useEffect(() => {
    void loadWords();
    const ends = [followPoints(), doc.follow()];
    return () => ends.forEach((end) => end());
  }, []);
  return (
    <div class={`program-page show-${side.value}`}>
      <WatchOnly needs="program" />
      <Bar />
      <div class="program-tabs">
        <Segmented
          label={t('program.shown')}
          value={side.value}
          options={[
            { id: 'program', name: t('nav.program'), icon: 'program' },
            { id: 'run', name: t('program.runAndLook'), icon: 'run' },
          ]}
          onChange={(id) => (side.value = id)}
        />
      </div>
      <div class="program-body">
        <section class="program-main" aria-label={t('nav.program')}>
          <ConflictNotice />
          <DraftNotice />
          <RunningNotice />
          {doc.fileName.value === '' ? <Nothing /> : view.value === 'text' ? <CodeView /> : <StepsView />}
        </section>
        <RunPanel />
      </div>
    </div>
  );
}

function Nothing() {
  return (
    <Empty icon="program" text={t('program.none')}>
      <Button label={t('program.new')} icon="plus" tone="primary" onClick={() => open((close) => <NewFileDialog onClose={close} />)} />
    </Empty>
  );
}

function fileState(): string {
  if (doc.fileName.value === '') return '';
  if (!doc.dirty.value) return t('program.stateSaved');
  switch (doc.draftState.value) {
    case 'waiting':
    case 'here':
      return t('program.stateWaiting');
    case 'keeping':
      return t('program.stateKeeping');
    default:
      return t('program.stateDraft');
  }
}

function Bar() {
  const name = doc.fileName.value;
  return (
    <div class="program-bar" role="toolbar" aria-label={t('program.bar')}>
      <button
        type="button"
        class="program-file"
        aria-haspopup="dialog"
        title={name ? t('program.fileIs', { name }) : t('program.files')}
        onClick={() => open((close) => <FilesDialog onClose={close} />)}
      >
        <Icon name="folder" size={22} />
        <span>
          {name && <span class="hidden-text">{t('program.program')} </span>}
          <strong>{name || t('program.files')}</strong>
          <small>{fileState()}</small>
          {name && <span class="hidden-text">, {t('program.openAnother')}</span>}
        </span>
        <Icon name="down" size={18} />
      </button>
      <Button
        label={t('program.save')}
        icon="save"
        tone={doc.dirty.value ? 'primary' : 'plain'}
        disabled={!doc.dirty.value || !mayProgram.value}
        class="program-save"
        onClick={() => void doc.save()}
      />
      <Button
        label={t('program.versions')}
        icon="clock"
        bare
        disabled={name === ''}
        onClick={() => open((close) => <VersionsDialog onClose={close} />)}
      />
      {view.value === 'steps' && <Button label={t('program.undo')} icon="undo" bare disabled={!doc.canUndo.value} onClick={doc.undo} />}
      <span class="grow" />
      <CheckChip />
      <Segmented
        label={t('program.as')}
        value={view.value}
        options={[
          { id: 'steps', name: t('program.asSteps'), icon: 'layers' },
          { id: 'text', name: t('program.asText'), icon: 'edit' },
        ]}
        onChange={(id) => (view.value = id)}
      />
    </div>
  );
}

function CheckChip() {
  if (!doc.isProgram.value || doc.fileName.value === '') return null;
  const errors = doc.errors.value;
  const warnings = doc.problems.value.length + doc.elsewhere.value.length - errors;
  const text = !doc.checked.value
    ? t('program.checking')
    : errors > 0
      ? t('program.errors', { count: errors })
      : warnings > 0
        ? t('program.warnings', { count: warnings })
        : t('program.noErrors');
  const tone = !doc.checked.value ? '' : errors > 0 ? 'bad' : warnings > 0 ? 'warn' : 'good';
  return (
    <span class={`chip ${tone} program-check`} role="status">
      <Icon name={!doc.checked.value ? 'clock' : errors + warnings > 0 ? 'alarm' : 'check'} size={16} />
      <span class="full">{text}</span>
      {errors + warnings > 0 && (
        <span class="few" aria-hidden="true">
          {errors || warnings}
        </span>
      )}
    </span>
  );
}
