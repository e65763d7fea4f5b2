/** Opens dialogs from anywhere: `ask(…)` a question, `open(…)` any dialog. */
import { signal } from '@preact/signals';
import type { ComponentChildren } from 'preact';
import { Confirm, type Question } from './Dialog';

type Shown = (close: () => void) => ComponentChildren;
export const shownDialog = signal<Shown | null>(null);

export function open(dialog: Shown): void {
  shownDialog.value = dialog;
}
export function close(): void {
  shownDialog.value = null;
}
export function ask(question: Question): void {
  open((done) => <Confirm question={question} onClose={done} />);
}

export function ShownDialog() {
  const shown = shownDialog.value;
  return shown ? <>{shown(close)}</> : null;
}
