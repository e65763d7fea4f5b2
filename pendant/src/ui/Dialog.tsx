import type { ComponentChildren } from 'preact';
import { useSignalEffect } from '@preact/signals';
import { useEffect, useId, useRef } from 'preact/hooks';
import { t } from '../i18n';
import { Button, type Tone } from './controls';

interface DialogProps {
  title: string;
  /** Undefined if the dialog must be answered. */
  onClose?: () => void;
  actions?: ComponentChildren;
  wide?: boolean;
  /** Shown at the side of the page instead of in its middle. */
  side?: boolean;
  /** The page behind is not dimmed. */
  clear?: boolean;
  children?: ComponentChildren;
}

/**
 * A modal dialog. The page behind it is inert except for Stop, which the dialog shows too (see StopButton).
 */
export function Dialog({ title, onClose, actions, wide, side, clear, children }: DialogProps) {
  const id = useId();
  const box = useRef<HTMLDivElement>(null);
  useEffect(() => {
    const before = document.activeElement as HTMLElement | null;
    const first = box.current?.querySelector<HTMLElement>('[autofocus], input, select, .dialog-body button, .dialog-actions button');
    (first ?? box.current)?.focus();
    return () => before?.focus?.();
  }, []);
  return (
    <div
      class={`veil ${side ? 'side' : ''} ${clear ? 'clear' : ''}`}
      onPointerDown={(e) => {
        if (e.target === e.currentTarget) onClose?.();
      }}
    >
      <div
        ref={box}
        class={`dialog ${wide ? 'wide' : ''}`}
        role="dialog"
        aria-modal="true"
        aria-labelledby={id}
        tabIndex={-1}
        onKeyDown={(e) => {
          if (e.key === 'Escape' && !e.defaultPrevented) {
            e.stopPropagation();
            onClose?.();
          }
          if (e.key === 'Tab') keepInside(e, box.current);
        }}
      >
        <header class="dialog-head">
          <h2 id={id}>{title}</h2>
          {onClose && <Button label={t('dialog.close')} icon="close" bare tone="quiet" onClick={onClose} />}
        </header>
        <div class="dialog-body">{children}</div>
        {actions && <footer class="dialog-actions">{actions}</footer>}
      </div>
    </div>
  );
}

/** Tab cycles through the dialog's elements and Stop, which stays reachable. */
function keepInside(event: KeyboardEvent, box: HTMLElement | null): void {
  if (!box) return;
  const all = [
    ...box.querySelectorAll<HTMLElement>('button:not(:disabled), input:not(:disabled), select:not(:disabled), textarea, a[href], [tabindex="0"]'),
    ...document.querySelectorAll<HTMLElement>('.stop-button'),
  ];
  const at = all.indexOf(document.activeElement as HTMLElement);
  const next = event.shiftKey ? at - 1 : at + 1;
  event.preventDefault();
  all[(next + all.length) % all.length]?.focus();
}

export interface Question {
  title: string;
  text?: string;
  action: string;
  tone?: Tone;
  onYes: () => void;
  /** A second answer, which does less. */
  less?: { action: string; onPick: () => void };
  /** Reads signals. When it becomes false, the question is obsolete and the dialog closes. */
  still?: () => boolean;
}

/** A question with one positive answer, or two; closing it means no. */
export function Confirm({ question, onClose }: { question: Question; onClose: () => void }) {
  useSignalEffect(() => {
    if (question.still && !question.still()) onClose();
  });
  const { less } = question;
  const answer = (act: () => void) => {
    onClose();
    act();
  };
  return (
    <Dialog
      title={question.title}
      onClose={onClose}
      actions={
        <>
          <Button label={t('dialog.cancel')} onClick={onClose} />
          {less && <Button label={less.action} onClick={() => answer(less.onPick)} />}
          <Button label={question.action} tone={question.tone ?? 'primary'} onClick={() => answer(question.onYes)} />
        </>
      }
    >
      {question.text && <p>{question.text}</p>}
    </Dialog>
  );
}
