import { signal } from '@preact/signals';
import { useEffect, useRef, useState } from 'preact/hooks';
import { t } from '../../i18n';
import { program as tasksNow, request, status } from '../../state/cell';
import { base, fileName, sameFile } from '../program/documents';
import { chosen } from './Choice';
import { linesIn, type TaskPlace } from './here';
import { shortName } from './Now';

/** The file whose text is shown, as it was read; '' if no file could be read. */
export const shownText = signal({ file: '', hash: '' });
/** Increases when the text must be read again, because it has changed. */
export const readAgain = signal(0);

/** The text of the running program, or of the one that Start runs. The first of the current lines stays visible. */
export function Text() {
  const program = status.value?.program;
  const going = !!program && !program.ended && !program.ready;
  const file = (!going && chosen.value) || (program ? shortName(program.file) : '');
  const [lines, setLines] = useState<string[]>([]);
  const list = useRef<HTMLOListElement>(null);
  const ended = !going;
  const hash = sameFile(file, fileName.value) ? base.value : '';  // changes when the file is saved here
  useEffect(() => {
    setLines([]);
    shownText.value = { file: '', hash: '' };
    if (!file) return;
    let left = false;
    request('files.read', { name: file }).then(
      (got) => {
        if (left) return;
        setLines(got.text.split('\n'));
        shownText.value = { file, hash: got.hash };
      },
      () => undefined,
    );
    return () => {
      left = true;
    };
  }, [file, ended, hash, readAgain.value]);
  const here = linesIn(file, program ?? null, (tasksNow.value?.tasks ?? []) as TaskPlace[]);
  const line = here[0] ?? -1;
  useEffect(() => {
    const box = list.current;
    const row = box?.children[line - 1] as HTMLElement | undefined;
    if (box && row) box.scrollTop = row.offsetTop - box.clientHeight / 2;
  }, [line, lines]);
  if (lines.length === 0) return null;
  return (
    <ol class="run-text" ref={list} tabIndex={0} aria-label={t('run.text')}>
      {lines.map((text, i) => (
        <li key={i} class={here.includes(i + 1) ? 'here' : ''} aria-current={here.includes(i + 1) ? 'step' : undefined}>
          <span aria-hidden="true">{i + 1}</span>
          <code>{text || ' '}</code>
        </li>
      ))}
    </ol>
  );
}
