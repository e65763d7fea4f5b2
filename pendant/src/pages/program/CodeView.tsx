/** Shows a program's text in CodeMirror, which is loaded on first use. */
import { effect, untracked } from '@preact/signals';
import { useEffect, useRef, useState } from 'preact/hooks';
import { t } from '../../i18n';
import { mayProgram } from '../../state/cell';
import { names } from '../../state/points';
import { Button, Loading } from '../../ui/controls';
import type { ProgramEditor } from './codemirror';
import * as doc from './documents';
import { language } from './words';

export function CodeView() {
  const box = useRef<HTMLDivElement>(null);
  const [failed, setFailed] = useState(false);
  const [ready, setReady] = useState(false);
  const words = language.value;
  useEffect(() => {
    let editor: ProgramEditor | null = null;
    let ended = false;
    const ends: (() => void)[] = [];
    import('./codemirror').then(
      ({ ProgramEditor: Editor }) => {
        if (ended || !box.current) return;
        editor = new Editor(box.current, doc.text.peek(), {
          label: t('program.text'),
          language: words,
          names: () => names.peek(),
          phrases: phrases(),
          onChange: doc.edit,
          onLine: (line) => (doc.atLine.value = line),
          onBreakpoint: (line) => void doc.toggleBreakpoint(line),
        });
        ends.push(...tie(editor));
        setReady(true);
      },
      () => setFailed(true),
    );
    return () => {
      ended = true;
      ends.forEach((end) => end());
      editor?.destroy();
      setReady(false);
    };
  }, [words]);
  if (failed) return <p class="program-note">{t('page.failed')}</p>;
  return (
    <div class="program-code">
      {!ready && <Loading />}
      <div class="program-editor" ref={box} />
    </div>
  );
}

/** Updates the editor when the signals change. Returns functions that end the updates. */
function tie(editor: ProgramEditor): (() => void)[] {
  let file = doc.fileName.peek();
  let first = true;
  return [
    effect(() => {
      doc.revision.value;
      const name = doc.fileName.value;
      const now = untracked(() => doc.text.value);
      const line = untracked(() => doc.atLine.value);
      if (name !== file) editor.open(now);
      else editor.take(now);
      if (!first && name === file && line > 1) editor.goTo(line);
      first = false;
      file = name;
    }),
    effect(() => editor.showProblems(doc.problems.value)),
    effect(() => editor.showLive(doc.liveLines.value)),
    effect(() => {
      doc.revision.value;
      editor.showBreakpoints(doc.breakpoints.value);
    }),
    effect(() => {
      const wanted = doc.wantedLine.value;
      if (wanted === null) return;
      editor.goTo(wanted);
      doc.wantedLine.value = null;
    }),
  ];
}

function phrases(): Record<string, string> {
  return {
    Find: t('editor.find'),
    Replace: t('editor.replace'),
    next: t('editor.next'),
    previous: t('editor.previous'),
    all: t('editor.all'),
    'match case': t('editor.case'),
    regexp: t('editor.regexp'),
    'by word': t('editor.word'),
    replace: t('editor.replaceOne'),
    'replace all': t('editor.replaceAll'),
    close: t('dialog.close'),
  };
}

/** Toggles a breakpoint at the cursor's line; for touch screens. */
export function BreakpointButton() {
  const line = doc.atLine.value;
  return (
    <Button
      label={t('program.breakpointAt', { line })}
      icon="pin"
      disabled={!doc.fileName.value || !mayProgram.value}
      pressed={doc.breakpoints.value.includes(line)}
      onClick={() => void doc.toggleBreakpoint(line)}
    />
  );
}
