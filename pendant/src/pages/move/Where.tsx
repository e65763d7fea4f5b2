import { t } from '../../i18n';
import { jogMode } from '../../state/jog';
import { beat, valueOf } from '../../state/live';
import { armOrder, models } from '../../state/models';
import { robot } from '../../state/cell';
import { angle, angleUnit, jointText, mm, jointTitle } from '../../ui/format';
import { rollPitchYaw } from '../../view3d/chain';
import { inFrame, shownFrame, tcpPose } from './axes';

/** The values that the keys do not show: the TCP while jogging joints, the joints while jogging the TCP. */
export function Where() {
  return jogMode.value === 'joint' ? <Tcp /> : <Joints />;
}

function Tcp() {
  beat.value;
  const frame = shownFrame();
  const at = inFrame(tcpPose(), frame.pose);
  const turned = rollPitchYaw(at.q);
  const tool = (models.value[robot.value?.name ?? '']?.tool as { name?: string } | undefined)?.name;
  const cells = [
    ...(['X', 'Y', 'Z'] as const).map((name, i) => [name, mm(at.p[i]!), 'mm']),
    ...(['RX', 'RY', 'RZ'] as const).map((name, i) => [name, angle(turned[i]!), angleUnit()]),
  ];
  return (
    <section class="where" aria-label={t('move.position')}>
      <h3>
        {t('move.position')} <small>{t('move.in', { frame: frame.name })}</small>
        {tool && tool !== 'none' && <small class="tool">{t('move.toolName', { name: tool })}</small>}
      </h3>
      <Values cells={cells as [string, string, string][]} />
    </section>
  );
}

function Joints() {
  const info = robot.value;
  if (!info) return null;
  const cells = armOrder(info).map((i) => info.joints[i]!).map((joint): [string, string, string] => [
    jointTitle(joint.name),
    jointText(valueOf(`${joint.interface}/position`), joint.unit),
    '',
  ]);
  return (
    <section class="where" aria-label={t('move.joint')}>
      <h3>{t('move.joint')}</h3>
      <Values cells={cells} />
    </section>
  );
}

function Values({ cells }: { cells: [string, string, string][] }) {
  return (
    <dl class="where-values">
      {cells.map(([name, value, unit]) => (
        <div key={name}>
          <dt>{name}</dt>
          <dd>
            {value} {unit && <small>{unit}</small>}
          </dd>
        </div>
      ))}
    </dl>
  );
}
