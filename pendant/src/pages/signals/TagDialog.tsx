/** One tag: all its properties, and the actions on it. */
import { useState } from 'preact/hooks';
import { t, word } from '../../i18n';
import { able } from '../../state/abilities';
import { attempt, mayMove } from '../../state/cell';
import { forcedHere, forceTag, releaseTag, setTag, tagInfos, tagNow } from '../../state/tags';
import { Button, Field, Segmented } from '../../ui/controls';
import { Dialog } from '../../ui/Dialog';
import { changedText, directionWord, Value, whoText } from './index';

/** What a rule sets: the words of the tag's own values. */
const ruleText = (then: unknown): string => (typeof then === 'boolean' ? t(then ? 'signals.on' : 'signals.off') : String(then));

export function TagDialog({ name, onClose }: { name: string; onClose: () => void }) {
  const info = tagInfos.value.find((each) => each.name === name);
  const tag = info ? tagNow(info) : null;
  const [wanted, setWanted] = useState(() => (tag ? String(tag.value) : ''));
  if (!tag) return null;
  const flag = typeof tag.value === 'boolean';
  const numeric = typeof tag.value === 'number';
  const typed = numeric ? Number(wanted.replace(',', '.')) : wanted;
  const problem = numeric && wanted.trim() !== '' && !Number.isFinite(typed as number) ? t('signals.badNumber') : '';
  const bad = !mayMove.value || problem !== '' || (numeric && wanted.trim() === '');
  const value: unknown = flag ? wanted === 'true' : typed;
  const measured = tag.tag && tag.direction === 'in';
  const mine = forcedHere.value.includes(name);
  const facts: [string, string][] = [
    [t('signals.type'), [word('signals.is', tag.type), tag.unit].filter(Boolean).join(', ')],
    [t('signals.direction'), directionWord(tag.direction)],
    [t('signals.source'), tag.source],
    [t('signals.quality'), word('signals.q', tag.quality)],
    [t('signals.changed'), changedText(tag)],
    ...Object.entries(tag.rules ?? {}).map(([rule, then]): [string, string] => [word('signals.rule', rule), ruleText(then)]),
    ...(tag.output !== null && tag.output !== undefined ? [[t('signals.output'), String(tag.output)] as [string, string]] : []),
  ];
  return (
    <Dialog title={name} onClose={onClose} side>
      <p class="signals-now">
        <Value tag={tag} />
      </p>
      {flag ? (
        <Segmented
          label={t('signals.newValue')}
          value={wanted}
          options={[
            { id: 'true', name: t('signals.on') },
            { id: 'false', name: t('signals.off') },
          ]}
          onChange={setWanted}
        />
      ) : (
        <Field label={t('signals.newValue')} value={wanted} unit={tag.unit} numeric={numeric} problem={problem} onInput={setWanted} />
      )}
      <div class="row">
        <Button label={t('signals.set')} icon="check" tone="primary" disabled={bad || measured || tag.forced} title={measured ? t('signals.measured') : undefined} onClick={() => void setTag(name, value)} />
        {mine ? (
          <Button label={t('signals.release')} icon="undo" tone="warn" onClick={() => releaseTag(name)} />
        ) : (
          <Button label={t(measured ? 'signals.simulate' : 'signals.force')} icon="lock" tone="warn" disabled={bad || tag.forced} onClick={() => void forceTag(name, value)} />
        )}
        {mine && <Button label={t('signals.forceNew')} icon="lock" disabled={bad} onClick={() => void forceTag(name, value)} />}
      </div>
      <p class="note">{t(measured ? 'signals.simulateWhy' : 'signals.forceWhy')}</p>
      {tag.forced && !mine && (
        <div class="row">
          <p class="signals-other">{t('signals.forcedElsewhere', { who: whoText(tag) })}</p>
          {able('tags.release') && <Button label={t('signals.release')} icon="undo" disabled={!mayMove.value} onClick={() => void attempt('tags.release', { name })} />}
        </div>
      )}
      <dl class="signals-facts">
        {facts.map(([title, text]) => (
          <div key={title}>
            <dt>{title}</dt>
            <dd>{text}</dd>
          </div>
        ))}
      </dl>
    </Dialog>
  );
}
