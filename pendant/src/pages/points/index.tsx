/** Points: where the robot was taught to go; frames and tools; and the cell's other data. */
import { useEffect, useState } from 'preact/hooks';
import { t } from '../../i18n';
import { WatchOnly } from '../../shell/Control';
import { complain, mayMove, request } from '../../state/cell';
import { type DataValue, followPoints, loadPoints, pointsKnown, values } from '../../state/points';
import { toast } from '../../state/toasts';
import { open } from '../../ui/ask';
import { Button, Empty, Loading, Segmented } from '../../ui/controls';
import { mm } from '../../ui/format';
import { Icon } from '../../ui/Icon';
import { RobotView } from '../../view3d/RobotView';
import { choose, chosen, query, shown, shownKind } from './choice';
import { Detail } from './Detail';
import { FrameWizard } from './FrameWizard';
import './points.css';
import { Teach } from './Teach';
import { ToolWizard } from './ToolWizard';

const roomy = matchMedia('(min-width: 900px)');

export default function Page() {
  const [wide, setWide] = useState(roomy.matches);
  useEffect(() => {
    const change = () => setWide(roomy.matches);
    roomy.addEventListener('change', change);
    const end = followPoints();
    return () => {
      roomy.removeEventListener('change', change);
      end();
      chosen.value = [];
    };
  }, []);
  return (
    <div class={`points-page ${chosen.value.length ? 'has-choice' : ''}`}>
      <WatchOnly />
      <div class="points-left">
        <Teach />
        <Bar />
        <List />
      </div>
      <div class="points-right">
        {wide && (
          <div class="points-picture">
            <RobotView />
          </div>
        )}
        <Detail />
      </div>
    </div>
  );
}

async function undo(): Promise<void> {
  try {
    const answer = await request<{ what: string }>('points.undo');
    toast({ kind: 'ok', text: t('points.undone', { what: answer.what }) });
    await loadPoints();
  } catch (error) {
    complain(error);
  }
}

function Bar() {
  return (
    <div class="points-bar">
      <div class="points-search">
        <Icon name="search" size={20} />
        <input type="search" aria-label={t('points.search')} placeholder={t('points.search')} value={query.value} onInput={(e) => (query.value = e.currentTarget.value)} />
      </div>
      <Segmented
        label={t('points.shown')}
        value={shownKind.value}
        options={[
          { id: 'points', name: t('nav.points') },
          { id: 'data', name: t('points.data') },
        ]}
        onChange={(id) => {
          shownKind.value = id;
          chosen.value = [];
        }}
      />
      <div class="points-wizards">
        <Button label={t('points.frame')} icon="cube" disabled={!mayMove.value} onClick={() => open((close) => <FrameWizard onClose={close} />)} />
        <Button label={t('points.tool')} icon="target" disabled={!mayMove.value} onClick={() => open((close) => <ToolWizard onClose={close} />)} />
        <Button label={t('points.undo')} icon="undo" bare disabled={!mayMove.value} onClick={() => void undo()} />
      </div>
    </div>
  );
}

function List() {
  if (!pointsKnown.value) return <Loading />;
  const groups = shown.value;
  if (groups.length === 0)
    return (
      <Empty icon="points" text={values.value.length === 0 ? t('points.none') : query.value ? t('points.notFound') : t('points.noneOf')}>
        {query.value && <Button label={t('points.clearSearch')} onClick={() => (query.value = '')} />}
      </Empty>
    );
  return (
    <div class="points-list" role="group" aria-label={t('nav.points')}>
      {groups.map((group) => (
        <section key={`${group.group}${group.title}`} aria-label={group.title}>
          <h3>
            <Icon name={group.group ? 'layers' : 'folder'} size={16} /> {group.title}
          </h3>
          <ul>
            {group.values.map((each) => (
              <Row key={each.name} value={each} />
            ))}
          </ul>
        </section>
      ))}
    </div>
  );
}

function Row({ value }: { value: DataValue }) {
  const on = chosen.value.includes(value.name);
  return (
    <li class={on ? 'chosen' : ''}>
      <label class="points-check">
        <input type="checkbox" checked={on} aria-label={t('points.choose', { name: value.name })} onChange={() => choose(value.name, true)} />
      </label>
      <button type="button" aria-pressed={on} onClick={() => choose(value.name, false)}>
        <Icon name={iconOf(value)} size={20} />
        <span>
          <strong>{value.name}</strong>
          <small>{summary(value)}</small>
        </span>
        {value.taught?.frame && <span class="chip">{value.taught.frame}</span>}
      </button>
    </li>
  );
}

function iconOf(value: DataValue) {
  if (value.kind === 'pose') return 'points' as const;
  if (value.kind === 'joints') return 'turnRight' as const;
  return value.kind === 'boolean' ? ('signals' as const) : ('program' as const);
}

export function summary(value: DataValue): string {
  if (value.pose) return `X ${mm(value.pose.p[0])}  Y ${mm(value.pose.p[1])}  Z ${mm(value.pose.p[2])} mm`;
  if (value.kind === 'joints') return t('points.jointCount', { count: Object.keys(value.joints ?? {}).length });
  return value.text;
}

