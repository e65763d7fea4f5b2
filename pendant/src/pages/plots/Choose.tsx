/** Chooses the curves: common sets with one press, any others by search. */
import { useState } from 'preact/hooks';
import { t } from '../../i18n';
import { cell } from '../../state/cell';
import { armOrder } from '../../state/models';
import { Button, Empty, Search } from '../../ui/controls';
import { Dialog } from '../../ui/Dialog';
import { chosen, kMostTraces, pairOf, readable, shown, traces } from './traces';

const kShownAtOnce = 80;

export function ChooseDialog({ onClose }: { onClose: () => void }) {
  const [words, setWords] = useState('');
  const on = shown.value.map((each) => each.name);
  const wanted = words.toLowerCase().split(/\s+/).filter(Boolean);
  const found = traces.value.filter((each) => wanted.every((word) => `${each.name} ${readable(each.name)}`.toLowerCase().includes(word)));
  const toggle = (name: string) => (chosen.value = on.includes(name) ? on.filter((each) => each !== name) : [...on, name]);
  const full = on.length >= kMostTraces;
  return (
    <Dialog title={t('plots.choose')} wide onClose={onClose} actions={<Button label={t('dialog.ok')} tone="primary" onClick={onClose} />}>
      <section aria-label={t('plots.sets')}>
        <h3>{t('plots.sets')}</h3>
        <div class="row plots-sets">
          {sets().map(({ name, list }) => (
            <Button key={name} label={name} pressed={list.length === on.length && list.every((each) => on.includes(each))} onClick={() => (chosen.value = list)} />
          ))}
        </div>
      </section>
      <Search label={t('plots.search')} value={words} onInput={setWords} />
      {full && <p class="note">{t('plots.full', { most: kMostTraces })}</p>}
      {found.length === 0 && <Empty icon="plots" text={t('plots.notFound')} />}
      <ul class="plots-all">
        {found.slice(0, kShownAtOnce).map((each) => (
          <li key={each.name}>
            <label>
              <input type="checkbox" checked={on.includes(each.name)} disabled={full && !on.includes(each.name)} onChange={() => toggle(each.name)} />
              <span title={each.name}>{readable(each.name)}</span>
              <small>{each.unit}</small>
            </label>
          </li>
        ))}
      </ul>
      {found.length > kShownAtOnce && <p class="note">{t('plots.more', { count: found.length - kShownAtOnce })}</p>}
    </Dialog>
  );
}

/** The sets whose curves exist. */
function sets(): { name: string; list: string[] }[] {
  const known = new Set(traces.value.map((each) => each.name));
  const out: { name: string; list: string[] }[] = [];
  const add = (name: string, list: string[]) => {
    const there = list.filter((each) => known.has(each)).slice(0, kMostTraces);
    if (there.length) out.push({ name, list: there });
  };
  const robots = cell.value?.robots ?? [];
  for (const robot of robots) {
    const joints = armOrder(robot).map((i) => robot.joints[i]!);
    const of = robots.length > 1 ? `${robot.name}: ` : '';
    add(of + t('plots.setJoints'), joints.flatMap((joint) => pairOf(joint.interface)));
    add(of + t('plots.setVelocities'), joints.map((joint) => `${joint.interface}/velocity`));
    add(of + t('plots.setEfforts'), joints.map((joint) => `${joint.interface}/effort`));
    add(of + t('plots.setTcp'), ['x', 'y', 'z'].map((axis) => `${robot.name}/tcp/${axis}`));
    add(of + t('plots.setSpeed'), [`${robot.name}/tcp/speed`]);
    for (const joint of joints) add(`${of}${joint.name.replace(/_joint$/, '').replaceAll('_', ' ')}`, pairOf(joint.interface));
  }
  add(t('plots.setLoop'), ['loop/period_us', 'loop/cost_us', 'loop/late']);
  return out;
}
