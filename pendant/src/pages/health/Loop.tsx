/** The control loop: late cycles, cycle times, and the time that each part takes. */
import { number, t, word } from '../../i18n';
import { cell } from '../../state/cell';
import { health, type Limit, limits } from '../../state/health';
import { Card, Empty, Loading } from '../../ui/controls';
import { clockTime, duration, shownIn } from '../../ui/format';
import { bars, type Times } from '../../wire/health';

const us = (value: number) => (value >= 10_000 ? `${number(value / 1000, 1)} ms` : `${number(value, value < 10 ? 1 : 0)} µs`);

export function Loop() {
  const now = health.value;
  if (!now) return <Loading />;
  const period = now.rate > 0 ? 1e6 / now.rate : NaN;
  // Skipped cycles count as late too. If the computer was suspended, there may be more of them than of
  // executed cycles.
  const share = now.cycles > 0 ? Math.min(100, (100 * now.late) / now.cycles) : 0;
  return (
    <>
      <div class="health-figures">
        <Figure name={t('health.rate')} value={`${number(now.rate, 0)} Hz`} />
        <Figure name={t('health.running')} value={clockTime(now.seconds)} />
        <Figure name={t('health.cycles')} value={number(now.cycles, 0)} />
        <Figure name={t('health.late')} value={number(now.late, 0)} note={`${number(share, share < 1 ? 3 : 0)} %`} tone={share > 0.1 ? 'warn' : 'good'} />
        {now.cost && <Figure name={t('health.load')} value={`${number((100 * now.cost.p99) / period, 1)} %`} note={t('health.loadNote')} tone={now.cost.p99 > 0.7 * period ? 'warn' : 'good'} />}
        <Figure name={t('health.clamps')} value={number(now.clamps, 0)} />
      </div>
      <div class="health-grid">
        <Histogram title={t('health.cost')} note={t('health.costNote')} times={now.cost} />
        <Histogram title={t('health.wakeUp')} note={t('health.wakeUpNote')} times={now.wakeUp} />
        <Histogram title={t('health.period')} note={t('health.periodNote', { us: number(period, 0) })} times={now.period} />
        <Limits />
        <Parts />
      </div>
    </>
  );
}

function Figure({ name, value, note, tone = '' }: { name: string; value: string; note?: string; tone?: string }) {
  return (
    <div class={`health-figure ${tone}`}>
      <span>{name}</span>
      <strong>{value}</strong>
      {note && <small>{note}</small>}
    </div>
  );
}

const kBars = 32;

function Histogram({ title, note, times }: { title: string; note: string; times: Times | null }) {
  return (
    <Card title={title}>
      <p class="note">{note}</p>
      {!times ? <p class="note">{t('health.notTimed')}</p> : <Bars times={times} title={title} />}
    </Card>
  );
}

function Bars({ times, title }: { times: Times; title: string }) {
  const list = bars(times, kBars);
  const most = Math.max(...list.map((each) => each.count), 1);
  // Logarithmic height, because rare long cycles matter more than frequent short ones.
  const height = (count: number) => (count === 0 ? 0 : 6 + (94 * Math.log10(1 + count)) / Math.log10(1 + most));
  const words = t('health.words', { p50: us(times.p50), p99: us(times.p99), max: us(times.max) });
  return (
    <>
      {list.length > 0 && (
        <div class="health-bars" role="img" aria-label={`${title}: ${words}`}>
          {list.map((each, i) => (
            <i key={i} style={{ '--height': `${height(each.count)}%` }} class={each.from >= times.p99 ? 'rare' : ''} title={`${us(each.from)} – ${us(each.to)}: ${each.count}`} />
          ))}
        </div>
      )}
      {list.length > 0 && (
        <div class="health-scale" aria-hidden="true">
          <span>{us(list[0]!.from)}</span>
          <span>{us(list[list.length - 1]!.to)}</span>
        </div>
      )}
      <dl class="health-times">
        {(
          [
            [t('health.half'), times.p50],
            [t('health.p99'), times.p99],
            [t('health.max'), times.max],
          ] as const
        ).map(([name, value]) => (
          <div key={name}>
            <dt>{name}</dt>
            <dd>{us(value)}</dd>
          </div>
        ))}
      </dl>
    </>
  );
}

function Parts() {
  const list = health.value?.parts ?? [];
  return (
    <Card title={t('health.parts')} class="wide">
      {list.length === 0 ? (
        <p class="note">{t('health.notTimed')}</p>
      ) : (
        <table class="plain">
          <thead>
            <tr>
              <th scope="col">{t('signals.name')}</th>
              <th scope="col" class="right">
                {t('health.rate')}
              </th>
              <th scope="col" class="right">
                {t('health.half')}
              </th>
              <th scope="col" class="right">
                {t('health.max')}
              </th>
              <th scope="col" class="right">
                {t('health.missed')}
              </th>
            </tr>
          </thead>
          <tbody>
            {list.map((each) => (
              <tr key={each.kind + each.name}>
                <th scope="row">{each.name}</th>
                <td class="right">{number(each.rate, 0)} Hz</td>
                <td class="right">{each.cost ? us(each.cost.p50) : '–'}</td>
                <td class="right">{each.cost ? us(each.cost.max) : '–'}</td>
                <td class="right">{number(each.missed, 0)}</td>
              </tr>
            ))}
          </tbody>
        </table>
      )}
    </Card>
  );
}

/** Joint limits that clamped commands, each with its cause and remedy. */
function Limits() {
  const list = limits.value;
  return (
    <Card title={t('health.limits')} class="wide">
      <p class="note">{t('health.limitsNote')}</p>
      {list.length === 0 ? <Empty icon="check" text={t('health.noLimits')} /> : list.map((each) => <Clamp key={each.interface + each.limit} clamp={each} />)}
    </Card>
  );
}

/** A value of the interface in its unit of display. Joint values use the units of the settings. */
function inItsUnit(interfaceName: string, value: number | null): string {
  if (value === null) return t('health.noNumber');
  const quantity = interfaceName.slice(interfaceName.lastIndexOf('/') + 1);
  const joint = cell.value?.robots.flatMap((each) => each.joints).find((each) => interfaceName.startsWith(`${each.interface}/`));
  const per = { position: '', velocity: '/s', acceleration: '/s2' }[quantity];
  const { unit, factor } = joint && per !== undefined ? shownIn(joint.unit + per) : { unit: '', factor: 1 };
  return `${number(value * factor, 3)} ${unit}`.trim();
}

function Clamp({ clamp }: { clamp: Limit }) {
  const { interface: name, limit, count } = clamp;
  const ago = Math.max(0, (health.value?.seconds ?? clamp.time_s) - clamp.time_s);
  const facts: [string, string][] = [
    [t('health.count'), number(count, 0)],
    [t('health.asked'), inItsUnit(name, clamp.asked)],
    [t('health.given'), inItsUnit(name, clamp.given)],
    [t('health.when'), `${clockTime(clamp.time_s)} (${t('health.ago', { time: duration(ago) })})`],
    [t('health.commands'), clamp.claimed_by || t('health.nobody')],
  ];
  return (
    <section class="health-clamp" aria-label={`${name}, ${word('health.lim', limit)}`}>
      <h3>
        {name} <span class="chip">{word('health.lim', limit)}</span>
      </h3>
      <dl class="health-times">
        {facts.map(([what, value]) => (
          <div key={what}>
            <dt>{what}</dt>
            <dd>{value}</dd>
          </div>
        ))}
      </dl>
      <p>{word('health.why', limit)}</p>
      <p>
        <b>{t('alarms.do')}:</b> {word('health.do', limit)}
      </p>
    </section>
  );
}
