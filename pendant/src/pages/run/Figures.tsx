import { number, t } from '../../i18n';
import { cell, connected, parts, robot, status } from '../../state/cell';
import { lastCycle, meanCycle } from '../../state/cycle';
import { beat, valueOf } from '../../state/live';
import { scene } from '../../state/models';
import { duration } from '../../ui/format';
import { partsDone } from './parts';

export function Figures() {
  beat.value;
  const program = status.value?.program;
  const counted = partsDone(Object.values(parts.value), scene.value?.things ?? []);
  const several = (cell.value?.robots.length ?? 0) > 1;
  const speed = valueOf(`${robot.value?.name ?? ''}/tcp/speed`);
  return (
    <dl class="run-figures">
      <Figure name={t('run.cycles')} value={program ? String(program.passes) : '–'} />
      <Figure
        name={t('run.cycleTime')}
        value={program ? duration(lastCycle.value) : '–'}
        note={program && Number.isFinite(meanCycle.value) ? `⌀ ${duration(meanCycle.value)}` : ''}
      />
      <Figure name={several ? t('run.tcpSpeedOf', { robot: robot.value?.name ?? '' }) : t('run.tcpSpeed')} value={number(Number.isFinite(speed) ? speed * 1000 : NaN, 0)} note="mm/s" />
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
