/** The chosen points: their values and the possible actions. */
import { useState } from 'preact/hooks';
import { t } from '../../i18n';
import { able } from '../../state/abilities';
import { cell, complain, mayProgram, request, robot } from '../../state/cell';
import { changePoints, type DataValue, goodName, groupNames, isPlace, isTool, values } from '../../state/points';
import { toast } from '../../state/toasts';
import { ask, open } from '../../ui/ask';
import { Button, Empty, Field } from '../../ui/controls';
import { Dialog } from '../../ui/Dialog';
import { angle, angleUnit, jointText, mm } from '../../ui/format';
import { rollPitchYaw } from '../../view3d/chain';
import type { Pose } from '../../wire/types';
import { GoKey, type Goal } from '../move/GoKey';
import { chosen, chosenValues } from './choice';
import { Shift } from './Shift';

function goalOf(value: DataValue): Goal | null {
  if (value.joints && value.kind === 'joints') return { joints: value.joints };
  return value.world ? { pose: value.world } : null;
}

export function Detail() {
  const list = chosenValues.value;
  if (list.length === 0) return <Empty icon="points" text={t('points.chooseOne')} />;
  const only = list.length === 1 ? list[0]! : null;
  return (
    <section class="points-detail" aria-label={only ? only.name : t('points.many', { count: list.length })}>
      <header>
        <h2>{only ? only.name : t('points.many', { count: list.length })}</h2>
        <Button label={t('dialog.close')} icon="close" bare tone="quiet" onClick={() => (chosen.value = [])} />
      </header>
      {only && isTool(only) && <p class="note">{t('points.toolIsUsed', { name: only.name })}</p>}
      {only && isPlace(only.kind) && !isTool(only) && <GoKey key={only.name} goal={goalOf(only)} />}
      <Actions list={list} only={only} />
      {only && <Numbers value={only} />}
    </section>
  );
}

// --- actions

function Actions({ list, only }: { list: DataValue[]; only: DataValue | null }) {
  const may = mayProgram.value;
  const names = list.map((each) => each.name);
  const poses = list.every((each) => each.kind === 'pose' && !isTool(each));
  return (
    <div class="points-actions">
      {only && isPlace(only.kind) && !isTool(only) && (
        <Button
          label={t('points.touchUp')}
          icon="pin"
          disabled={!may}
          onClick={() =>
            ask({ title: t('points.touchUpQ', { name: only.name }), text: touchUpWords(), action: t('points.touchUp'), onYes: () => void touchUp(only) })
          }
        />
      )}
      {poses && <Button label={t('points.shift')} icon="move" disabled={!may} onClick={() => open((close) => <Shift names={names} onClose={close} />)} />}
      {only && <Button label={t('points.rename')} icon="edit" disabled={!may} onClick={() => open((close) => <Rename value={only} onClose={close} />)} />}
      {only && <Button label={t('points.change')} icon="settings" disabled={!may} onClick={() => open((close) => <Change value={only} onClose={close} />)} />}
      {able('points.group') && <Button label={t('points.setGroup')} icon="layers" disabled={!may} onClick={() => open((close) => <Group list={list} onClose={close} />)} />}
      <Button label={t('points.delete')} icon="trash" disabled={!may} onClick={() => void remove(names)} />
    </div>
  );
}

/** With several robots it matters whose position is taken. */
const touchUpWords = () => ((cell.value?.robots.length ?? 0) > 1 ? t('points.touchUpOf', { robot: robot.value?.name ?? '' }) : t('points.touchUpText'));

async function touchUp(value: DataValue): Promise<void> {
  const args = { name: value.name, robot: robot.value?.name ?? '', kind: value.kind === 'joints' ? ('joints' as const) : ('pose' as const), frame: value.taught?.frame || undefined, replace: true };
  if (await changePoints('points.teach', args)) toast({ kind: 'ok', text: t('points.touched', { name: value.name }) });
}

/** Asks no question, because it can be undone. */
async function remove(names: string[]): Promise<void> {
  for (const name of names) if (!(await changePoints('points.delete', { name }))) return;
  chosen.value = [];
  toast({ kind: 'info', text: t('points.deleted', { names: names.join(', ') }), detail: t('points.deletedUndo') });
}

function Rename({ value, onClose }: { value: DataValue; onClose: () => void }) {
  const [name, setName] = useState(value.name);
  const taken = values.value.some((each) => each.name === name && each.name !== value.name);
  const problem = name !== '' && !goodName(name) ? t('points.badName') : taken ? t('points.exists') : '';
  const bad = name === '' || name === value.name || problem !== '';
  const go = async () => {
    if (bad) return;
    onClose();
    try {
      const answer = await request('points.rename', { name: value.name, to: name });
      chosen.value = [name];
      const uses = answer.uses ?? [];
      if (uses.length)
        toast({ kind: 'warning', text: t('points.renamedUses', { name: value.name }), detail: uses.map((use) => `${use.file}:${use.line}`).join(', ') });
      else toast({ kind: 'ok', text: t('points.renamed', { name }) });
    } catch (error) {
      complain(error);
    }
  };
  return (
    <Dialog
      title={t('points.renameTitle', { name: value.name })}
      onClose={onClose}
      actions={
        <>
          <Button label={t('dialog.cancel')} onClick={onClose} />
          <Button label={t('points.rename')} tone="primary" disabled={bad} onClick={() => void go()} />
        </>
      }
    >
      <Field label={t('points.newName')} value={name} problem={problem} onInput={setName} onEnter={() => void go()} />
    </Dialog>
  );
}

/** Edits the values as text, in the form of programs and data files. */
function Change({ value, onClose }: { value: DataValue; onClose: () => void }) {
  const [text, setText] = useState(() => literalOf(value));
  const go = async () => {
    onClose();
    if (await changePoints('points.set', { name: value.name, value: text })) toast({ kind: 'ok', text: t('points.changed', { name: value.name }) });
  };
  return (
    <Dialog
      title={t('points.changeTitle', { name: value.name })}
      onClose={onClose}
      actions={
        <>
          <Button label={t('dialog.cancel')} onClick={onClose} />
          <Button label={t('step.apply')} tone="primary" disabled={text.trim() === ''} onClick={() => void go()} />
        </>
      }
    >
      <Field label={t('points.value')} value={text} onInput={setText} onEnter={() => void go()} />
      <p class="note">{t('points.valueForms')}</p>
    </Dialog>
  );
}

export function literalOf(value: DataValue): string {
  const digits = (x: number, n: number) => String(Number(x.toFixed(n)));
  if (value.pose) {
    const turned = rollPitchYaw(value.pose.q).map((a) => `${digits((a * 180) / Math.PI, 4)}deg`);
    const frame = value.taught?.frame ? `, frame = "${value.taught.frame}"` : '';
    return `pose(${[...value.pose.p.map((x) => `${digits(1000 * x, 3)}mm`), ...turned].join(', ')}${frame})`;
  }
  if (value.joints) return `joints(${Object.entries(value.joints).map(([name, x]) => `${name} = ${digits(x, 6)}`).join(', ')})`;
  if (value.kind === 'text') return JSON.stringify(value.value ?? value.text);
  return value.value === null ? value.text : String(value.value);
}

function Group({ list, onClose }: { list: DataValue[]; onClose: () => void }) {
  const [name, setName] = useState(list[0]?.group ?? '');
  const go = async (to: string) => {
    onClose();
    const names = list.map((each) => each.name);
    if (await changePoints('points.group', { names, group: to }))
      toast({ kind: 'ok', text: to ? t('points.grouped', { names: names.join(', '), group: to }) : t('points.ungrouped', { names: names.join(', ') }) });
  };
  return (
    <Dialog
      title={t('points.setGroup')}
      onClose={onClose}
      actions={
        <>
          <Button label={t('dialog.cancel')} onClick={onClose} />
          <Button label={t('step.apply')} tone="primary" onClick={() => void go(name.trim())} />
        </>
      }
    >
      <Field label={t('points.group')} value={name} placeholder={t('points.noGroup')} onInput={setName} onEnter={() => void go(name.trim())} />
      <div class="row">
        {groupNames.value.map((each) => (
          <Button key={each} label={each} pressed={each === name} onClick={() => setName(each)} />
        ))}
      </div>
    </Dialog>
  );
}

// --- values

function Numbers({ value }: { value: DataValue }) {
  const facts: [string, string][] = [
    [t('points.file'), value.file],
    [t('points.group'), value.group],
    [t('points.frameIs'), value.kind !== 'pose' ? '' : isTool(value) ? t('points.onFlange') : value.taught?.frame || t('points.world')],
    [t('points.toolIs'), value.taught?.tool ?? ''],
    [t('points.robotIs'), value.taught?.robot ?? ''],
  ];
  return (
    <>
      {value.pose && <PoseTable pose={value.pose} />}
      {value.joints && <JointTable joints={value.joints} />}
      {!value.pose && !value.joints && <p class="points-text">{value.text}</p>}
      <dl class="points-facts">
        {facts
          .filter(([, text]) => text !== '')
          .map(([name, text]) => (
            <div key={name}>
              <dt>{name}</dt>
              <dd>{text}</dd>
            </div>
          ))}
      </dl>
    </>
  );
}

export function PoseTable({ pose }: { pose: Pose }) {
  const turned = rollPitchYaw(pose.q);
  const cells: [string, string][] = [
    ...(['X', 'Y', 'Z'] as const).map((axis, i): [string, string] => [axis, `${mm(pose.p[i]!, 2)} mm`]),
    ...(['RX', 'RY', 'RZ'] as const).map((axis, i): [string, string] => [axis, `${angle(turned[i]!, 2)} ${angleUnit()}`]),
  ];
  return <Cells cells={cells} />;
}

function JointTable({ joints }: { joints: Record<string, number> }) {
  const infos = robot.value?.joints ?? [];
  const unit = (name: string) => infos.find((each) => each.name === name)?.unit ?? 'rad';
  return <Cells cells={Object.entries(joints).map(([name, value]) => [name.replace(/_joint$/, '').replaceAll('_', ' '), jointText(value, unit(name), 2)])} />;
}

function Cells({ cells }: { cells: [string, string][] }) {
  return (
    <dl class="points-cells">
      {cells.map(([name, text]) => (
        <div key={name}>
          <dt>{name}</dt>
          <dd>{text}</dd>
        </div>
      ))}
    </dl>
  );
}

