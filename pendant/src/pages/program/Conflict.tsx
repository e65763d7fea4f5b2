/**
 * Messages about the file: it was changed by another client, a draft was found, or it runs with an older
 * text.
 */
import { useMemo, useState } from 'preact/hooks';
import { moment, t } from '../../i18n';
import { ask, open } from '../../ui/ask';
import { Button, Segmented } from '../../ui/controls';
import { Dialog } from '../../ui/Dialog';
import { Icon } from '../../ui/Icon';
import { diff, type Hunk, merged } from './diff';
import * as doc from './documents';

export function ConflictNotice() {
  if (!doc.theirs.value) return null;
  return (
    <div class="banner bad" role="alert">
      <Icon name="alarm" />
      <div>
        <strong>{t('program.changedMeanwhile', { name: doc.fileName.value })}</strong>
        <p>{t('program.changedText')}</p>
      </div>
      <Button label={t('program.compare')} tone="primary" onClick={() => open((close) => <ConflictDialog onClose={close} />)} />
    </div>
  );
}

export function DraftNotice() {
  const found = doc.foundDraft.value;
  if (!found || !doc.dirty.value || doc.theirs.value) return null;
  const when = moment(found.saved_s);
  return (
    <div class="banner" role="status">
      <Icon name="edit" />
      <div>
        <strong>{found.by ? t('program.draftOf', { name: found.by, when }) : t('program.draftFrom', { when })}</strong>
      </div>
      <Button
        label={t('program.discardDraft')}
        onClick={() =>
          ask({
            title: t('program.discardDraftQ'), text: t('program.discardDraftText'), action: t('program.discardDraft'), tone: 'danger',
            onYes: doc.discardDraft,
          })
        }
      />
      <Button label={t('program.keepDraft')} bare icon="check" tone="quiet" onClick={() => (doc.foundDraft.value = null)} />
    </div>
  );
}

export function RunningNotice() {
  if (!doc.running.value) return null;
  return (
    <p class="program-note" role="status">
      <Icon name="lock" size={18} /> {t('program.runsWithItsText')}
    </p>
  );
}

function ConflictDialog({ onClose }: { onClose: () => void }) {
  const other = doc.theirs.value;
  const hunks = useMemo(() => diff(doc.text.value, other?.text ?? ''), [other]);
  const changes = hunks.filter((each) => !each.same).length;
  const [choice, setChoice] = useState<('a' | 'b')[]>(() => Array<'a' | 'b'>(changes).fill('a'));
  if (!other) return null;
  const all = choice.every((each) => each === 'a') ? 'a' : choice.every((each) => each === 'b') ? 'b' : 'mixed';
  const action = all === 'a' ? t('program.saveMine') : all === 'b' ? t('program.takeTheirs') : t('program.saveMixed');
  return (
    <Dialog
      title={t('program.changedMeanwhile', { name: doc.fileName.value })}
      wide
      onClose={onClose}
      actions={
        <>
          <Button label={t('dialog.cancel')} onClick={onClose} />
          <Button label={action} tone="primary" onClick={() => (onClose(), void doc.saveMerged(merged(hunks, choice)))} />
        </>
      }
    >
      <Segmented
        label={t('program.whatCounts')}
        value={all}
        options={[
          { id: 'a', name: t('program.mine') },
          { id: 'b', name: t('program.theirs') },
          ...(all === 'mixed' ? [{ id: 'mixed' as const, name: t('program.mixed') }] : []),
        ]}
        onChange={(id) => id !== 'mixed' && setChoice(Array<'a' | 'b'>(changes).fill(id))}
      />
      <SideBySide
        hunks={hunks}
        titles={[t('program.mine'), t('program.theirs')]}
        choice={choice}
        onChoose={(index, side) => setChoice(choice.map((each, i) => (i === index ? side : each)))}
      />
    </Dialog>
  );
}

interface SideBySideProps {
  hunks: Hunk[];
  titles: [string, string];
  choice?: ('a' | 'b')[];
  onChoose?: (index: number, side: 'a' | 'b') => void;
}

const kAround = 3;

/** Both texts side by side. The user can choose a side for each difference. */
export function SideBySide({ hunks, titles, choice, onChoose }: SideBySideProps) {
  let index = -1;
  return (
    <div class="program-diff" role="group" aria-label={`${titles[0]} · ${titles[1]}`}>
      <div class="heads" aria-hidden="true">
        <strong>{titles[0]}</strong>
        <strong>{titles[1]}</strong>
      </div>
      {hunks.map((hunk, at) => {
        if (hunk.same) return <Same key={at} hunk={hunk} first={at === 0} last={at === hunks.length - 1} />;
        const mine = ++index;
        return (
          <div key={at} class="hunk">
            {(['a', 'b'] as const).map((side) => {
              const lines = hunk[side];
              const chosen = choice?.[mine] === side;
              const body = <Lines lines={lines} from={side === 'a' ? hunk.aLine : hunk.bLine} />;
              if (!onChoose)
                return (
                  <div key={side} class={`side ${side}`} role="group" aria-label={titles[side === 'a' ? 0 : 1]}>
                    {body}
                  </div>
                );
              return (
                <button
                  key={side}
                  type="button"
                  class={`side ${side} ${chosen ? 'chosen' : ''}`}
                  aria-pressed={chosen}
                  aria-label={`${titles[side === 'a' ? 0 : 1]}: ${lines.join('\n') || t('program.noLines')}`}
                  onClick={() => onChoose(mine, side)}
                >
                  {body}
                  {chosen && <Icon name="check" size={20} />}
                </button>
              );
            })}
          </div>
        );
      })}
    </div>
  );
}

function Lines({ lines, from }: { lines: string[]; from: number }) {
  if (lines.length === 0) return <span class="none">{t('program.noLines')}</span>;
  return (
    <span class="lines">
      {lines.map((line, i) => (
        <span key={i} class="line">
          <small>{from + i}</small>
          <code>{line || ' '}</code>
        </span>
      ))}
    </span>
  );
}

function Same({ hunk, first, last }: { hunk: Hunk; first: boolean; last: boolean }) {
  const [whole, setWhole] = useState(false);
  const head = first ? 0 : kAround;
  const tail = last ? 0 : kAround;
  const hidden = hunk.a.length - head - tail;
  if (whole || hidden < 2) return <Both hunk={hunk} from={0} to={hunk.a.length} />;
  return (
    <>
      <Both hunk={hunk} from={0} to={head} />
      <button type="button" class="fold" onClick={() => setWhole(true)}>
        {t('program.sameLines', { count: hidden })}
      </button>
      <Both hunk={hunk} from={hunk.a.length - tail} to={hunk.a.length} />
    </>
  );
}

function Both({ hunk, from, to }: { hunk: Hunk; from: number; to: number }) {
  if (from >= to) return null;
  return (
    <div class="hunk same">
      <div class="side">
        <Lines lines={hunk.a.slice(from, to)} from={hunk.aLine + from} />
      </div>
      <div class="side" aria-hidden="true">
        <Lines lines={hunk.b.slice(from, to)} from={hunk.bLine + from} />
      </div>
    </div>
  );
}
