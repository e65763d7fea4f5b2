/** Curves of any field, tag or loop figure: commanded beside measured values, pause, zoom, cursor, export. */
import { signal } from '@preact/signals';
import { useEffect, useState } from 'preact/hooks';
import { number, t } from '../../i18n';
import { beat } from '../../state/live';
import { darkNow, kept } from '../../state/settings';
import { open } from '../../ui/ask';
import { Button, Empty, Loading, Segmented } from '../../ui/controls';
import { ChooseDialog } from './Choose';
import { csv } from './history';
import { RecordKey, RecordNote } from './Recording';
import './plots.css';
import { chosen, colourOf, history, isCommand, readable, record, shown, sliceOf, titleOf, type Trace, valuesAt } from './traces';
import type { Plot, View } from './draw';

const seconds = kept<string>('plots.seconds', '15');
/** The paused time window; null while the newest values are shown. */
const still = signal<{ from: number; to: number } | null>(null);
/** The time under the cursor. */
const cursor = signal<number | null>(null);
const kRedrawMs = 66;

function view(): View {
  if (still.peek()) return still.peek()!;
  const to = history.newest;
  return { from: to - Number(seconds.peek()), to };
}

export default function Page() {
  useEffect(record, []);
  return (
    <div class="plots-page">
      <div class="plots-bar" role="toolbar" aria-label={t('plots.bar')}>
        {still.value ? (
          <Button label={t('plots.live')} icon="run" tone="good" onClick={() => (still.value = null)} />
        ) : (
          <Button label={t('plots.pause')} icon="pause" onClick={() => (still.value = view())} />
        )}
        <Segmented
          label={t('plots.window')}
          value={seconds.value}
          options={['5', '15', '60', '300'].map((id) => ({ id, name: Number(id) < 60 ? `${id} s` : `${Number(id) / 60} min` }))}
          onChange={(id) => {
            seconds.value = id;
            if (still.value) still.value = { from: still.value.to - Number(id), to: still.value.to };
          }}
        />
        <Button label={t('plots.zoomIn')} icon="plus" bare onClick={() => zoom(0.5)} />
        <Button label={t('plots.zoomOut')} icon="minus" bare onClick={() => zoom(2)} />
        <Button label={t('plots.earlier')} icon="left" bare onClick={() => shift(-0.5)} />
        <Button label={t('plots.later')} icon="right" bare disabled={!still.value} onClick={() => shift(0.5)} />
        <span class="grow" />
        <RecordKey />
        <Button label={t('plots.csv')} icon="download" disabled={shown.value.length === 0} onClick={exportCsv} />
        <Button label={t('plots.choose')} icon="plus" tone="primary" onClick={() => open((close) => <ChooseDialog onClose={close} />)} />
      </div>
      <RecordNote />
      {shown.value.length === 0 ? <Empty icon="plots" text={t('plots.none')} /> : <Curves />}
    </div>
  );
}

/** Pauses, and scales the time window about its middle by the factor. */
function zoom(factor: number): void {
  const { from, to } = view();
  const half = Math.max(0.02, ((to - from) * factor) / 2);
  const middle = still.peek() ? (from + to) / 2 : to - half;
  still.value = { from: middle - half, to: middle + half };
}
function shift(share: number): void {
  const { from, to } = view();
  const by = share * (to - from);
  const limited = Math.min(by, history.newest - to);
  still.value = { from: from + limited, to: to + limited };
}

function exportCsv(): void {
  const { from, to } = view();
  const list = shown.peek();
  const slice = sliceOf(from, to, list);
  const url = URL.createObjectURL(new Blob([csv(slice, list.map(titleOf))], { type: 'text/csv' }));
  const link = document.createElement('a');
  link.href = url;
  link.download = `polyarm-${new Date().toISOString().slice(0, 19).replaceAll(':', '-')}.csv`;
  link.click();
  setTimeout(() => URL.revokeObjectURL(url), 1000);
}

/** One plot per unit. */
function byUnit(list: Trace[]): { unit: string; list: Trace[] }[] {
  const out = new Map<string, Trace[]>();
  for (const each of list) out.set(each.unit, [...(out.get(each.unit) ?? []), each]);
  return [...out].map(([unit, mine]) => ({ unit, list: mine }));
}

function Curves() {
  const list = shown.value;
  return (
    <div class="plots-curves">
      {byUnit(list).map(({ unit, list: mine }) => (
        <section key={unit} class="plots-one" aria-label={t('plots.ofUnit', { unit: unit || t('plots.noUnit') })}>
          <Legend list={mine} all={list} />
          <Curve unit={unit} list={mine} all={list} />
        </section>
      ))}
    </div>
  );
}

function Legend({ list, all }: { list: Trace[]; all: Trace[] }) {
  beat.value;
  const at = cursor.value ?? (still.value ? still.value.to : history.newest);
  const values = valuesAt(at, list);
  return (
    <ul class="plots-legend">
      {list.map((each, i) => (
        <li key={each.name}>
          <i class={isCommand(each.name) ? 'dashed' : ''} style={{ '--trace': colourOf(each.name, all, darkNow.value) }} aria-hidden="true" />
          <span title={each.name}>{readable(each.name)}</span>
          <output aria-label={readable(each.name)}>
            {number(values[i] ?? NaN, 4)} {each.unit}
          </output>
          <Button
            label={t('plots.remove', { name: readable(each.name) })}
            icon="close"
            bare
            tone="quiet"
            onClick={() => (chosen.value = all.map((one) => one.name).filter((name) => name !== each.name))}
          />
        </li>
      ))}
    </ul>
  );
}

function Curve({ unit, list, all }: { unit: string; list: Trace[]; all: Trace[] }) {
  const [box, setBox] = useState<HTMLDivElement | null>(null);
  const [ready, setReady] = useState(false);
  const dark = darkNow.value;
  const key = `${unit} ${list.map((each) => each.name).join('|')}${all.length}`;
  useEffect(() => {
    if (!box) return;
    let plot: Plot | null = null;
    let gone = false;
    let timer: ReturnType<typeof setInterval> | undefined;
    void import('./draw').then(({ Plot: Made }) => {
      if (gone) return;
      plot = new Made(box, unit, list.map((each) => ({ ...each, colour: colourOf(each.name, all, dark), dashed: isCommand(each.name) })), {
        onZoom: (from, to) => (still.value = { from, to }),
        onCursor: (time) => (cursor.value = time),
        onReset: () => (still.value = null),
      });
      setReady(true);
      let told = '';
      timer = setInterval(() => {
        const now = view();
        const mark = `${now.from}/${now.to}/${history.newest > now.to ? '' : history.newest}`;
        if (mark === told || Number.isNaN(now.to)) return;
        told = mark;
        plot?.show(sliceOf(now.from, now.to, list), now);
      }, kRedrawMs);
    });
    return () => {
      gone = true;
      clearInterval(timer);
      plot?.end();
    };
  }, [box, key, dark]);
  return (
    <div class="plots-canvas" ref={setBox} role="img" aria-label={t('plots.picture', { names: list.map((each) => readable(each.name)).join(', ') })}>
      {!ready && <Loading />}
    </div>
  );
}
