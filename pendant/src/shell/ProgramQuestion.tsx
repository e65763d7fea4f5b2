/** Shows a question of the program to the user (`wait user`), over any page, until it is answered. */
import { useState } from 'preact/hooks';
import { t } from '../i18n';
import { attempt, mayMove, program } from '../state/cell';
import { Button, Field } from '../ui/controls';
import { Icon } from '../ui/Icon';

export function ProgramQuestion() {
  const asked = program.value?.question;
  const [text, setText] = useState('');
  if (typeof asked !== 'string') return null;
  // The second line belongs to the answer: the default, or why the last answer was refused.
  const [question, note] = asked.split('\n');
  const answer = async () => {
    if (await attempt('program.answer', { text })) setText('');
  };
  return (
    <section class="banner question" role="alert" aria-label={t('question.label')}>
      <Icon name="hand" />
      <div>
        <strong>{question || t('question.wait')}</strong>
        {note && <p>{note}</p>}
      </div>
      <Field label={t('question.answer')} value={text} disabled={!mayMove.value} onInput={setText} onEnter={() => void answer()} />
      <Button label={t('question.go')} icon="run" tone="good" disabled={!mayMove.value} onClick={() => void answer()} />
    </section>
  );
}
