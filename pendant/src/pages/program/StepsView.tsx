/**
 * The program as a list of steps, for touch screens. Each step is a statement of the text; changing a step
 * changes the text.
 */
import { useEffect, useRef, useState } from 'preact/hooks';
import { t } from '../../i18n';
import { problemLine } from '../../i18n/told';
import { mayMove } from '../../state/cell';
import { names } from '../../state/points';
import { open } from '../../ui/ask';
import { Button, Empty } from '../../ui/controls';
import { Dialog } from '../../ui/Dialog';
import { Icon } from '../../ui/Icon';
import * as doc from './documents';
import { copyStatement, moveStatement, removeStatement } from './edits';
import { runFrom } from './RunPanel';
import { type KindOf, kindsIn, sentenceOf } from './sentence';
import type { Statement } from './statements';
import { openStepForm, openStepKinds } from './StepForm';

export function StepsView() {
  const list = doc.statements.value;
  const live = doc.liveLines.value;
  const chosen = list.find((each) => doc.atLine.value >= each.line && doc.atLine.value <= each.endLine) ?? null;
  const kindOf = kindsIn(list, names.value);
  const box = useRef<HTMLOListElement>(null);
  useEffect(() => {
    const wanted = doc.wantedLine.value;
    if (wanted === null) return;
    doc.wantedLine.value = null;
    box.current?.querySelector(`[data-line="${wanted}"]`)?.scrollIntoView({ block: 'center' });
  }, [doc.wantedLine.value]);
  useEffect(() => {
    box.current?.querySelector(`[data-line="${doc.atLine.peek()}"]`)?.scrollIntoView({ block: 'nearest' });
  }, [doc.revision.value]);
  useEffect(() => {
    if (live[0]) box.current?.querySelector(`[data-line="${live[0]}"]`)?.scrollIntoView({ block: 'nearest' });
  }, [live[0]]);
  if (!doc.isProgram.value) return <Empty icon="program" text={t('program.notSteps')} />;
  return (
    <div class="program-steps">
      {list.length === 0 ? (
        <Empty icon="plus" text={t('program.noSteps')} />
      ) : (
        <ol ref={box} aria-label={t('program.steps')}>
          {list.map((each) => (
            <Step key={each.line} step={each} kindOf={kindOf} live={live.includes(each.line)} chosen={each === chosen} />
          ))}
        </ol>
      )}
      <Actions step={chosen} />
    </div>
  );
}

/** The first breakpoint on any line of the statement. */
const breakpointOf = (step: Statement) => doc.breakpoints.value.find((line) => line >= step.line && line <= step.endLine);

function Step({ step, kindOf, live, chosen }: { step: Statement; kindOf: KindOf; live: boolean; chosen: boolean }) {
  const { icon, text, chips } = sentenceOf(step, kindOf);
  const wrong = doc.problems.value.filter((each) => each.line >= step.line && each.line <= step.endLine);
  const stops = breakpointOf(step) !== undefined;
  const kind = step.word === '#' ? 'comment' : step.closes ? 'closer' : step.opens || step.middle ? 'block' : '';
  return (
    <li data-line={step.line} style={{ '--depth': String(step.depth) }}>
      <button
        type="button"
        class={`program-step ${kind} ${live ? 'live' : ''} ${chosen ? 'chosen' : ''} ${wrong.some((each) => each.severity === 'error') ? 'wrong' : ''}`}
        aria-current={live ? 'step' : undefined}
        aria-pressed={chosen}
        onClick={() => (doc.atLine.value = step.line)}
        onDblClick={() => openStepForm(step)}
      >
        <small class="number">{step.line}</small>
        <Icon name={live ? 'run' : icon} size={20} />
        <span class="sentence">
          <span>{text}</span>
          {chips.map((chip) => (
            <span key={chip} class="clause">
              {chip}
            </span>
          ))}
          {step.comment && step.word !== '#' && <small>{step.comment}</small>}
          {wrong.map((each) => (
            <small key={each.what} class={each.severity}>
              {problemLine(each)}
            </small>
          ))}
        </span>
        {live && <span class="hidden-text">{t('program.isHere')}</span>}
        {stops && <span class="cm-mark break" role="img" aria-label={t('program.breakpoint')} />}
      </button>
    </li>
  );
}

function Actions({ step }: { step: Statement | null }) {
  const shift = (by: -1 | 1) => {
    const made = step && moveStatement(doc.text.value, step, by);
    if (made) doc.change(made.text, made.line);
  };
  const fixed = !step || step.closes || step.middle;
  return (
    <div class="program-actions" role="toolbar" aria-label={t('program.stepActions')}>
      <Button label={t('program.add')} icon="plus" tone="primary" onClick={() => openStepKinds(step)} />
      <Button label={t('program.edit')} icon="edit" disabled={!step || step.closes || (step.middle && step.word !== 'elif')} onClick={() => step && openStepForm(step)} />
      <Button label={t('program.up')} icon="up" bare disabled={fixed} onClick={() => shift(-1)} />
      <Button label={t('program.down')} icon="down" bare disabled={fixed} onClick={() => shift(1)} />
      <Button label={t('program.copy')} icon="copy" bare disabled={fixed} onClick={() => {
        const made = copyStatement(doc.text.value, step!);
        doc.change(made.text, made.line);
      }} />
      <Button label={t('program.breakpoint')} icon="pin" bare disabled={!step} pressed={!!step && breakpointOf(step) !== undefined} onClick={() => step && void doc.toggleBreakpoint(breakpointOf(step) ?? step.line)} />
      <Button label={t('program.fromHere')} icon="right" bare disabled={!step || !mayMove.value || step.word === '#'} onClick={() => step && void runFrom(step.line)} />
      <Button label={t('program.remove')} icon="trash" bare disabled={fixed} onClick={() => step && remove(step)} />
    </div>
  );
}

function remove(step: Statement): void {
  if (!step.opens || step.blockEnd <= step.endLine + 1) {
    doc.change(removeStatement(doc.text.value, step), Math.max(1, step.line - 1));
    return;
  }
  open((close) => <RemoveBlock step={step} onClose={close} />);
}

function RemoveBlock({ step, onClose }: { step: Statement; onClose: () => void }) {
  const [line] = useState(step.line);
  const go = (keep: boolean) => {
    onClose();
    doc.change(removeStatement(doc.text.value, step, keep), line);
  };
  return (
    <Dialog
      title={t('program.removeBlock')}
      onClose={onClose}
      actions={
        <>
          <Button label={t('dialog.cancel')} onClick={onClose} />
          <Button label={t('program.removeOnly')} onClick={() => go(true)} />
          <Button label={t('program.removeAll')} tone="danger" onClick={() => go(false)} />
        </>
      }
    >
      <p>{sentenceOf(step).text}</p>
    </Dialog>
  );
}
