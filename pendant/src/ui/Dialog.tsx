import type { ComponentChildren } from 'preact';
import { useSignalEffect } from '@preact/signals';
import { useEffect, useId, useRef } from 'preact/hooks';
import { t } from '../i18n';
import { Button, type Tone } from './controls';

interface DialogProps {
  title: string;
  /** Undefined where it must be answered. */
  onClose?: () => void;
  actions?: ComponentChildren;
  wide?: boolean;
  /** At the side, over the page's edge, rather than in its middle. */
  side?: boolean;
  /** What is behind stays clear to be seen. */
  clear?: boolean;
  children?: ComponentChildren;
}

/** A modal dialog: the page behind is inert but for Stop, which is shown in it, too (see StopButton). */
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

/** Tab goes round inside the dialog and on to Stop, which stays reachable. */
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
  /** Reads signals; once it is false the question makes no sense any more, and closes. */
  still?: () => boolean;
}

/** A question with one way to say yes; closing it says no. */
export function Confirm({ question, onClose }: { question: Question; onClose: () => void }) {
  useSignalEffect(() => {
    if (question.still && !question.still()) onClose();
  });
  return (
    <Dialog
      title={question.title}
      onClose={onClose}
      actions={
        <>
          <Button label={t('dialog.cancel')} onClick={onClose} />
          <Button
            label={question.action}
            tone={question.tone ?? 'primary'}
            onClick={() => {
              onClose();
              question.onYes();
            }}
          />
        </>
      }
    >
      {question.text && <p>{question.text}</p>}
    </Dialog>
  );
}
