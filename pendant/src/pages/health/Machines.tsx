/** Hardware components and controllers: their states, claimed interfaces, and changes of state. */
import type { Args, RequestName } from '../../state/cell';
import { useEffect, useState } from 'preact/hooks';
import { number, t, word } from '../../i18n';
import { causeWords, plain, problemLine, problemOf } from '../../i18n/told';
import { attempt, complain, mayAdminister, mayMove, request } from '../../state/cell';
import { type Component, type Controller, controllers, hardware, health, loadHealth } from '../../state/health';
import { recoverHardware } from '../../state/recovery';
import { ask, open } from '../../ui/ask';
import { Button, Empty } from '../../ui/controls';
import { Dialog } from '../../ui/Dialog';
import { WatchOnly } from '../../shell/Control';

const tone = (state: string) => (state === 'active' ? 'good' : state === 'inactive' || state === 'unconfigured' ? '' : 'bad');

function StateChip({ state }: { state: string }) {
  return <span class={`chip ${tone(state)}`}>{word('health.s', state)}</span>;
}

async function change<Name extends RequestName>(name: Name, args: Args<Name>): Promise<void> {
  await attempt<RequestName>(name, args);
  await loadHealth();
}

/**
 * Recovers a component. The controllers that failed with it start only if the user says so: the cell then starts these, and
 * no others.
 */
export function recover(name: string, controllers: string[] = []): void {
  ask({
    title: t('health.startQ'),
    text: controllers.length ? t('health.startNames', { name, controllers: controllers.join(', ') }) : t('health.startText', { name }),
    action: t('health.start'),
    onYes: () => void recoverHardware({ name, controllers: true }).then(loadHealth),
    less: { action: t('health.startNot'), onPick: () => void recoverHardware({ name }).then(loadHealth) },
    still: () => mayMove.value,
  });
}

export function Hardware() {
  const list = hardware.value;
  return (
    <>
      <WatchOnly needs="administer" />
      {list.length === 0 && <Empty icon="health" text={t('health.noHardware')} />}
      <ul class="health-list">
        {list.map((each) => (
          <ComponentCard key={each.name} component={each} />
        ))}
      </ul>
    </>
  );
}

function ComponentCard({ component }: { component: Component }) {
  const { name, state } = component;
  const fallen = health.value?.fallen.find((each) => each.component === name);
  const failed = !!fallen || (state !== 'active' && state !== 'inactive' && state !== 'unconfigured');
  const to = (next: string) => ask({
    title: t('health.toQ', { name, state: word('health.s', next) }),
    text: next === 'active' ? t('health.toActive') : t('health.toLess'),
    action: t('health.do'),
    onYes: () => void change('hardware.state', { name, state: next }),
    still: () => mayAdminister.value,
  });
  const users = [...new Set(component.commands.map((each) => each.claimed_by).filter(Boolean))];
  return (
    <li class={`health-item ${failed ? 'bad' : tone(state)}`}>
      <header>
        <h3>{name}</h3>
        <StateChip state={state} />
      </header>
      {fallen && <p class="health-bad">{t('health.failed', { cause: causeWords(fallen.cause_code, fallen.cause) })}</p>}
      <p class="note">
        {[component.type, component.plugin, component.rate ? `${number(component.rate, 0)} Hz` : ''].filter(Boolean).join(' · ')}
        {component.missed > 0 && ` · ${t('health.missed')}: ${component.missed}`}
      </p>
      <p class="note">
        {t('health.counts', { states: component.states.length, commands: component.commands.length })}
        {users.length > 0 && ` · ${t('health.usedBy', { names: users.join(', ') })}`}
      </p>
      <div class="row">
        {failed && <Button label={t('health.recover')} icon="undo" tone="warn" disabled={!mayMove.value} onClick={() => recover(name, fallen?.controllers)} />}
        {state !== 'active' && !failed && <Button label={t('health.activate')} icon="power" disabled={!mayAdminister.value} onClick={() => to('active')} />}
        {state === 'active' && !failed && <Button label={t('health.deactivate')} icon="power" disabled={!mayAdminister.value} onClick={() => to('inactive')} />}
      </div>
    </li>
  );
}

export function Controllers() {
  const list = controllers.value;
  return (
    <>
      <WatchOnly needs="administer" />
      {list.length === 0 && <Empty icon="health" text={t('health.noControllers')} />}
      {list.length > 0 && (
        <div class="row">
          <Button label={t('health.switch')} icon="repeat" tone="primary" disabled={!mayAdminister.value} onClick={() => open((close) => <SwitchDialog onClose={close} />)} />
        </div>
      )}
      <ul class="health-list">
        {list.map((each) => (
          <li key={each.name} class={`health-item ${tone(each.state)}`}>
            <header>
              <h3>{each.name}</h3>
              <StateChip state={each.state} />
            </header>
            <p class="note">
              {[each.type, each.rate ? `${number(each.rate, 0)} Hz` : '', each.stale ? t('health.stale') : '', each.missed ? `${t('health.missed')}: ${each.missed}` : ''].filter(Boolean).join(' · ')}
            </p>
            {each.claimed.length > 0 && <p class="note">{t('health.claims', { names: each.claimed.join(', ') })}</p>}
          </li>
        ))}
      </ul>
    </>
  );
}

interface Plan {
  ok: boolean;
  reason: string;
  advice?: string;
  start: string[];
  stop: string[];
}

/** Chooses the active controllers. Shows the effects before the switch. */
function SwitchDialog({ onClose }: { onClose: () => void }) {
  const [list] = useState<Controller[]>(() => controllers.peek().filter((each) => each.state === 'active' || each.state === 'inactive'));
  const [on, setOn] = useState(() => new Set(list.filter((each) => each.state === 'active').map((each) => each.name)));
  const [plan, setPlan] = useState<Plan | null>(null);
  const activate = list.filter((each) => on.has(each.name) && each.state !== 'active').map((each) => each.name);
  const deactivate = list.filter((each) => !on.has(each.name) && each.state === 'active').map((each) => each.name);
  const changes = activate.length + deactivate.length > 0;
  const args = { activate, deactivate };
  const key = JSON.stringify(args);
  useEffect(() => {
    setPlan(null);
    if (!changes) return;
    request('control.switch', { ...args, dry: true }).then(setPlan, (error: Error) => setPlan({ ok: false, reason: problemLine(problemOf(error)), start: [], stop: [] }));
  }, [key]);
  const toggle = (name: string) => {
    const next = new Set(on);
    if (!next.delete(name)) next.add(name);
    setOn(next);
  };
  const go = () => {
    onClose();
    request('control.switch', args).then(loadHealth, complain);
  };
  return (
    <Dialog
      title={t('health.switch')}
      onClose={onClose}
      actions={
        <>
          <Button label={t('dialog.cancel')} onClick={onClose} />
          <Button label={t('health.do')} tone="primary" disabled={!changes || plan?.ok !== true || !mayAdminister.value} onClick={go} />
        </>
      }
    >
      <p>{t('health.switchText')}</p>
      <ul class="health-switch">
        {list.map((each) => (
          <li key={each.name}>
            <label>
              <input type="checkbox" checked={on.has(each.name)} onChange={() => toggle(each.name)} />
              <span>{each.name}</span>
              <StateChip state={each.state} />
            </label>
          </li>
        ))}
      </ul>
      {plan && (
        <p role="status" class={plan.ok ? 'note' : 'health-bad'}>
          {plan.ok ? t('health.plan', { start: plan.start.join(', ') || '–', stop: plan.stop.join(', ') || '–' }) : [plain(plan.reason), plain(plan.advice ?? '')].filter(Boolean).join(' ')}
        </p>
      )}
    </Dialog>
  );
}
