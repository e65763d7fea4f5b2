/** The present tags with type, unit, direction, source and last writer; setting and forcing tags; links. */
import { signal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { number, t, word } from '../../i18n';
import { WatchOnly } from '../../shell/Control';
import { connected, mayMove, robot } from '../../state/cell';
import { cellTime } from '../../state/live';
import { kept } from '../../state/settings';
import { followTags, forcedHere, links, setTag, tagInfos, tagNow, tagsKnown } from '../../state/tags';
import type { TagState } from '../../wire/requests';
import { open } from '../../ui/ask';
import { Button, Card, Empty, Loading, Search, Segmented } from '../../ui/controls';
import { duration, nameParts } from '../../ui/format';
import { Icon } from '../../ui/Icon';
import './signals.css';
import { TagDialog } from './TagDialog';

type Which = 'all' | 'in' | 'out' | 'data' | 'forced';
const query = signal('');
const which = kept<Which>('signals.which', 'all');

export default function Page() {
  useEffect(followTags, []);
  return (
    <div class="signals-page">
      <WatchOnly />
      <div class="signals-bar">
        <Search class="signals-search" label={t('signals.search')} value={query.value} onInput={(text) => (query.value = text)} />
        <Segmented<Which>
          label={t('signals.shown')}
          value={which.value}
          options={[
            { id: 'all', name: t('signals.all') },
            { id: 'in', name: t('signals.in') },
            { id: 'out', name: t('signals.out') },
            { id: 'data', name: t('signals.variables') },
            { id: 'forced', name: t('signals.forced') },
          ]}
          onChange={(id) => (which.value = id)}
        />
      </div>
      <Forces />
      <div class="signals-body">
        <Table />
        <Links />
      </div>
    </div>
  );
}

function Forces() {
  const all = tagInfos.value.map(tagNow).filter((each) => each.forced);
  if (all.length === 0) return null;
  return (
    <div class="banner" role="status">
      <Icon name="lock" />
      <div>
        <strong>{t('signals.areForced', { names: all.map((each) => each.name).join(', ') })}</strong>
        {forcedHere.value.length > 0 && <p>{t('signals.forcedHere')}</p>}
      </div>
    </div>
  );
}

export function shownTags(all: TagState[], show: Which, words: string): TagState[] {
  const wanted = words.toLowerCase().split(/\s+/).filter(Boolean);
  return all.filter((each) => {
    if (show === 'in' && !/\bin\b|both/.test(each.direction)) return false;
    if (show === 'out' && !/\bout\b|both/.test(each.direction)) return false;
    if (show === 'data' && each.tag) return false;
    if (show === 'forced' && !each.forced) return false;
    const text = `${each.name} ${each.source} ${each.type} ${each.changed_by}`.toLowerCase();
    return wanted.every((one) => text.includes(one));
  });
}

function Table() {
  if (!tagsKnown.value) return robot.value && !connected.value ? <Empty icon="link" text={t('why.offline')} /> : <Loading />;
  const list = shownTags(tagInfos.value.map(tagNow), which.value, query.value);
  if (list.length === 0) return <Empty icon="signals" text={tagInfos.value.length ? t('signals.notFound') : t('signals.none')} />;
  return (
    <div class="signals-table">
      <table class="plain">
        <caption class="hidden-text">{t('nav.signals')}</caption>
        <thead>
          <tr>
            <th scope="col">{t('signals.name')}</th>
            <th scope="col">{t('signals.value')}</th>
            <th scope="col" class="far">{t('signals.direction')}</th>
            <th scope="col" class="far">{t('signals.source')}</th>
            <th scope="col" class="near">{t('signals.changed')}</th>
            <th scope="col">
              <span class="hidden-text">{t('signals.actions')}</span>
            </th>
          </tr>
        </thead>
        <tbody>
          {list.map((each) => (
            <Row key={each.name} tag={each} />
          ))}
        </tbody>
      </table>
    </div>
  );
}

export function directionWord(direction: string): string {
  return direction.split(', ').map((each) => word('signals.dir', each)).join(', ');
}

/** The last writer: its kind of program, or the name of the client. */
export const whoText = (tag: TagState) => (tag.changed_by ? word('signals.by', tag.changed_by) : t('signals.cell'));

/** When and by whom the tag was changed: `PLC, 3.2 s ago`. */
export function changedText(tag: TagState): string {
  if (!connected.value) return '–';
  if (tag.changed_s === null) return t('signals.never');
  const ago = Math.max(0, cellTime.value - tag.changed_s);
  return t('signals.ago', { who: whoText(tag), time: duration(ago) });
}

function Row({ tag }: { tag: TagState }) {
  const flag = typeof tag.value === 'boolean';
  const fixed = tag.direction === 'in' && tag.tag;
  return (
    <tr class={tag.forced ? 'forced' : ''}>
      <th scope="row">
        <strong>{nameParts(tag.name).flatMap((part, i) => (i === 0 ? [part] : [<wbr />, part]))}</strong>
        <small>
          {[word('signals.is', tag.type), tag.unit].filter(Boolean).join(' · ')}
          {tag.quality !== 'good' && <span class="chip warn">{word('signals.q', tag.quality)}</span>}
        </small>
      </th>
      <td>
        <Value tag={tag} />
      </td>
      <td class="far">{directionWord(tag.direction)}</td>
      <td class="far">
        <small>{tag.source}</small>
      </td>
      <td class="near">
        <small>{changedText(tag)}</small>
      </td>
      <td class="signals-do">
        {flag && !fixed && (
          <Button
            label={t(tag.value ? 'signals.turnOff' : 'signals.turnOn', { name: tag.name })}
            icon="power"
            bare
            disabled={!mayMove.value || tag.forced}
            onClick={() => void setTag(tag.name, !tag.value)}
          />
        )}
        <Button label={t('signals.open', { name: tag.name })} icon="edit" bare onClick={() => open((close) => <TagDialog name={tag.name} onClose={close} />)} />
      </td>
    </tr>
  );
}

export function Value({ tag }: { tag: TagState }) {
  if (!connected.value) return <span>–</span>;
  if (typeof tag.value === 'boolean')
    return (
      <span class={`signals-flag ${tag.value ? 'on' : ''}`}>
        <i aria-hidden="true" />
        {t(tag.value ? 'signals.on' : 'signals.off')}
        {tag.forced && <span class="chip warn">{t('signals.isForced')}</span>}
      </span>
    );
  return (
    <span class="signals-number">
      {typeof tag.value === 'number' ? number(tag.value, Number.isInteger(tag.value) ? 0 : 4) : tag.text} {tag.unit}
      {tag.forced && <span class="chip warn">{t('signals.isForced')}</span>}
    </span>
  );
}

function Links() {
  const list = links.value;
  if (list.length === 0 || !connected.value) return null;
  return (
    <Card title={t('signals.links')} class="signals-links">
      <ul>
        {list.map((each) => (
          <li key={each.name} class={each.up ? 'up' : 'down'}>
            <Icon name={each.up ? 'link' : 'alarm'} size={22} />
            <div>
              <strong>
                {each.name} <span class={`chip ${each.up ? 'good' : 'bad'}`}>{t(each.up ? 'signals.up' : 'signals.down')}</span>
              </strong>
              <small>{each.address}</small>
              {!each.up && each.reason && <p>{each.reason}</p>}
              <small>
                {t('signals.linkFacts', { tags: each.tags, ms: number(each.round_ms, 1), losses: each.losses })}
                {' · '}
                {t(each.on_loss === 'hold' ? 'signals.lossHold' : 'signals.lossGoOn')}
              </small>
            </div>
          </li>
        ))}
      </ul>
    </Card>
  );
}
