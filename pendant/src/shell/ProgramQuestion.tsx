/** Shows a question of the program to the user (`wait user`), over any page, until it is answered. */
import { useEffect, useState } from 'preact/hooks';
import { t } from '../i18n';
import { noteWords } from '../i18n/told';
import { attempt, mayMove, program, status } from '../state/cell';
import { Button, Field } from '../ui/controls';
import { Icon } from '../ui/Icon';

/** ms in which a second press does not count: it would answer the next question. */
const kOnePress = 500;

export function ProgramQuestion() {
  const asked = program.value?.question;
  const [text, setText] = useState('');
  /** True from a press until the program can have gone on. */
  const [sent, setSent] = useState(false);
  /** The question that was answered while the cell does not run. */
  const [answered, setAnswered] = useState('');
  const runs = status.value?.state === 'running';
  useEffect(() => {
    if (runs) setAnswered('');
  }, [runs]);
  if (typeof asked !== 'string') return null;
  // The second line belongs to the answer: the default, or why the last answer was refused.
  const [question, note] = asked.split('\n');
  const waits = answered === asked && !runs;
  const may = mayMove.value && !sent && !waits;
  const answer = async () => {
    if (!may) return;
    setSent(true);
    const taken = await attempt('program.answer', { text, question });
    setTimeout(() => setSent(false), taken ? kOnePress : 0);
    if (!taken) return;
    setText('');
    setAnswered(asked);
  };
  return (
    <section class="banner question" role="alert" aria-label={t('question.label')}>
      <Icon name="hand" />
      <div>
        <strong>{question || t('question.wait')}</strong>
        {waits ? <p>{t('question.answered')}</p> : note && <p>{noteWords(note)}</p>}
      </div>
      <Field label={t('question.answer')} value={text} disabled={!may} onInput={setText} onEnter={() => void answer()} />
      <Button label={t('question.go')} icon="run" tone="good" disabled={!may} onClick={() => void answer()} />
    </section>
  );
}
