import { number, t } from '../../i18n';
import { connected, parts, robot, status } from '../../state/cell';
import { lastCycle, meanCycle } from '../../state/cycle';
import { beat, valueOf } from '../../state/live';
import { scene } from '../../state/models';
import { duration } from '../../ui/format';

/** `done`: the parts that lie in a bin and are not held, or were removed from the cell; `all`: all parts. */
export function partsInBins(): { done: number; all: number } {
  const regions = (scene.value?.things ?? []).filter((thing) => thing.kind === 'bin');
  const all = Object.values(parts.value);
  const inside = all.filter(
    (part) =>
      part.taken ||
      (part.here &&
        !part.heldBy &&
        regions.some((bin) => bin.visuals[0]?.size?.every((side, i) => Math.abs(part.p[i]! - bin.p[i]!) <= side / 2 + 1e-6))),
  );
  return { done: inside.length, all: all.length };
}

export function Figures() {
  beat.value;
  const program = status.value?.program;
  const counted = partsInBins();
  const speed = valueOf(`${robot.value?.name ?? ''}/tcp/speed`);
  return (
    <dl class="run-figures">
      <Figure name={t('run.cycles')} value={program ? String(program.passes) : '–'} />
      <Figure
        name={t('run.cycleTime')}
        value={program ? duration(lastCycle.value) : '–'}
        note={program && Number.isFinite(meanCycle.value) ? `⌀ ${duration(meanCycle.value)}` : ''}
      />
      <Figure name={t('run.tcpSpeed')} value={number(Number.isFinite(speed) ? speed * 1000 : NaN, 0)} note="mm/s" />
      {counted.all > 0 && <Figure name={t('run.parts')} value={connected.value ? t('run.partsOf', counted) : '–'} />}
    </dl>
  );
}

function Figure({ name, value, note }: { name: string; value: string; note?: string }) {
  return (
    <div>
      <dt>{name}</dt>
      <dd>
        {value} {note && <small>{note}</small>}
      </dd>
    </div>
  );
}
