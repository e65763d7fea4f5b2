/** All robots with their pictures, to choose one for the cell. */
import { signal } from '@preact/signals';
import { useEffect, useState } from 'preact/hooks';
import { number, t } from '../../i18n';
import { cell, complain, fetchJson, mayAdminister } from '../../state/cell';
import { open } from '../../ui/ask';
import { Button, Empty, Field, Loading, Search, Select } from '../../ui/controls';
import { Dialog } from '../../ui/Dialog';
import { axesOf, type CatalogueEntry, fitting, kNoWish, makersOf, type Wish } from './robots';
import { Picture, Working } from './Overview';
import { restart, restarting } from './restart';

const all = signal<CatalogueEntry[] | null>(null);
const wish = signal<Wish>(kNoWish);
const kPage = 60;

const makerName = (maker: string) => maker.replaceAll('_', ' ').replace(/\b\w/g, (c) => c.toUpperCase());

export function Catalogue({ onDone }: { onDone: () => void }) {
  const [most, setMost] = useState(kPage);
  useEffect(() => {
    if (!all.peek()) fetchJson<CatalogueEntry[]>('/api/catalogue').then((list) => (all.value = list), complain);
  }, []);
  const list = all.value;
  if (!list) return <Loading />;
  const now = wish.value;
  const put = (next: Partial<Wish>) => {
    wish.value = { ...now, ...next };
    setMost(kPage);
  };
  const found = fitting(list, now);
  const bad = (text: string) => (text !== '' && !(Number(text) >= 0) ? t('signals.badNumber') : undefined);
  return (
    <>
      <div class="cell-wish" role="search" aria-label={t('cell.search')}>
        <Search class="cell-search" label={t('cell.search')} value={now.words} onInput={(words) => put({ words })} />
        <Select label={t('cell.maker')} value={now.maker} options={[{ id: '', name: t('cell.any') }, ...makersOf(list).map((id) => ({ id, name: makerName(id) }))]} onChange={(maker) => put({ maker })} />
        <Select label={t('cell.axes')} value={now.axes} options={[{ id: '', name: t('cell.any') }, ...axesOf(list).map((n) => ({ id: String(n), name: String(n) }))]} onChange={(axes) => put({ axes })} />
        <Field label={t('cell.reachLeast')} value={now.reach} unit="m" numeric problem={bad(now.reach)} onInput={(text) => put({ reach: text.replace(',', '.') })} />
        <Field label={t('cell.payloadLeast')} value={now.payload} unit="kg" numeric problem={bad(now.payload)} onInput={(text) => put({ payload: text.replace(',', '.') })} />
        <Select
          label={t('cell.order')}
          value={now.order}
          options={[
            { id: 'name', name: t('cell.byName') },
            { id: 'reach', name: t('cell.byReach') },
            { id: 'payload', name: t('cell.byPayload') },
          ]}
          onChange={(order) => put({ order: order as Wish['order'] })}
        />
      </div>
      <p class="note" role="status">
        {t('cell.found', { count: found.length, all: list.length })}
      </p>
      {restarting.value && <Working />}
      {found.length === 0 && (
        <Empty icon="search" text={t('cell.nothing')}>
          <Button label={t('cell.clear')} onClick={() => put(kNoWish)} />
        </Empty>
      )}
      <ul class="cell-robots">
        {found.slice(0, most).map((each) => (
          <li key={each.id}>
            <button type="button" onClick={() => open((close) => <ChooseDialog entry={each} onClose={close} onDone={onDone} />)}>
              <Picture id={each.id} title="" />
              <strong>{each.title || each.model}</strong>
              <small>{facts(each)}</small>
              {cell.value?.robots.some((robot) => robot.id === each.id) && <span class="chip good">{t('cell.inUse')}</span>}
            </button>
          </li>
        ))}
      </ul>
      {found.length > most && (
        <div class="row">
          <Button label={t('cell.more', { count: found.length - most })} onClick={() => setMost(most + kPage)} />
        </div>
      )}
    </>
  );
}

function facts(each: CatalogueEntry): string {
  const out = [t('cell.axesOf', { axes: each.axes })];
  if (each.reach) out.push(`${number(each.reach, 2)} m`);
  if (each.payload) out.push(`${number(each.payload, each.payload < 10 ? 1 : 0)} kg`);
  return out.join(' · ');
}

function ChooseDialog({ entry, onClose, onDone }: { entry: CatalogueEntry; onClose: () => void; onDone: () => void }) {
  const robots = cell.value?.robots ?? [];
  const [which, setWhich] = useState(robots[0]?.name ?? '');
  const go = async () => {
    onClose();
    const title = entry.title || entry.id;
    if (await restart(t('cell.changing', { title }), t('cell.changed', { title }), 'cell.change', { robot: which, model: entry.id })) onDone();
  };
  return (
    <Dialog
      title={entry.title || entry.id}
      onClose={onClose}
      actions={
        <>
          <Button label={t('dialog.cancel')} onClick={onClose} />
          <Button label={t('cell.use')} tone="primary" icon="check" disabled={!mayAdminister.value || restarting.value !== ''} onClick={() => void go()} />
        </>
      }
    >
      <div class="cell-choose">
        <Picture id={entry.id} title={entry.title} />
        <dl class="cell-facts">
          <div>
            <dt>{t('cell.maker')}</dt>
            <dd>{makerName(entry.maker)}</dd>
          </div>
          <div>
            <dt>{t('cell.axes')}</dt>
            <dd>{entry.axes}</dd>
          </div>
          <div>
            <dt>{t('cell.reach')}</dt>
            <dd>{entry.reach ? `${number(entry.reach, 3)} m` : '–'}</dd>
          </div>
          <div>
            <dt>{t('cell.payload')}</dt>
            <dd>{entry.payload ? `${number(entry.payload, 1)} kg` : '–'}</dd>
          </div>
          {entry.mass ? (
            <div>
              <dt>{t('cell.mass')}</dt>
              <dd>{number(entry.mass, 1)} kg</dd>
            </div>
          ) : null}
        </dl>
      </div>
      {robots.length > 1 && <Select label={t('cell.insteadOf')} value={which} options={robots.map((each) => ({ id: each.name, name: `${each.name} (${each.title})` }))} onChange={setWhich} />}
      <p>{t('cell.useText')}</p>
    </Dialog>
  );
}
