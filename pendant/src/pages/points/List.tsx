/** The points by group. Each group can be folded. */
import { t } from '../../i18n';
import { type DataValue, isTool, pointsKnown, values } from '../../state/points';
import { Button, Empty, Loading } from '../../ui/controls';
import { mm } from '../../ui/format';
import { Icon } from '../../ui/Icon';
import { choose, chooseAll, chosen, fold, folded, type PointGroup, query, shown, showGroup, shownGroup } from './choice';

export function List() {
  if (!pointsKnown.value) return <Loading />;
  const groups = shown.value;
  const narrowed = query.value !== '' || shownGroup.value !== null;
  if (groups.length === 0)
    return (
      <Empty icon="points" text={values.value.length === 0 ? t('points.none') : narrowed ? t('points.notFound') : t('points.noneOf')}>
        {narrowed && (
          <Button
            label={t('points.clearSearch')}
            onClick={() => {
              query.value = '';
              showGroup(null);
            }}
          />
        )}
      </Empty>
    );
  return (
    <div class="points-list" role="group" aria-label={t('nav.points')}>
      {groups.map((group) => (
        <Group key={group.key} group={group} />
      ))}
    </div>
  );
}

function Group({ group }: { group: PointGroup }) {
  const open = query.value !== '' || !folded.value.includes(group.key);
  const names = group.values.map((each) => each.name);
  return (
    <section aria-label={group.title}>
      <h3>
        <label class="points-check">
          <input
            type="checkbox"
            checked={names.every((each) => chosen.value.includes(each))}
            aria-label={t('points.chooseAll', { name: group.title })}
            onChange={() => chooseAll(group)}
          />
        </label>
        <button type="button" aria-expanded={open} onClick={() => fold(group.key)}>
          <Icon name={open ? 'down' : 'right'} size={18} />
          <Icon name={group.kind === 'tools' ? 'target' : group.kind === 'group' ? 'layers' : 'folder'} size={16} />
          <span>{group.title}</span>
          <small>{group.kind === 'tools' ? names.length : t('points.many', { count: names.length })}</small>
        </button>
      </h3>
      {open && (
        <ul>
          {group.values.map((each) => (
            <Row key={each.name} value={each} />
          ))}
        </ul>
      )}
    </section>
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
        {value.taught?.frame && !isTool(value) && <span class="chip">{value.taught.frame}</span>}
      </button>
    </li>
  );
}

function iconOf(value: DataValue) {
  if (isTool(value)) return 'target' as const;
  if (value.kind === 'pose') return 'points' as const;
  if (value.kind === 'joints') return 'turnRight' as const;
  return value.kind === 'boolean' ? ('signals' as const) : ('program' as const);
}

export function summary(value: DataValue): string {
  if (value.pose) return `X ${mm(value.pose.p[0])}  Y ${mm(value.pose.p[1])}  Z ${mm(value.pose.p[2])} mm`;
  if (value.kind === 'joints') return t('points.jointCount', { count: Object.keys(value.joints ?? {}).length });
  return value.text;
}

