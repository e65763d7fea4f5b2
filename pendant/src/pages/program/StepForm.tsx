/**
 * Forms to choose the kind of a new step and to edit a step. The resulting line is always shown and can be
 * edited.
 */
import { useState } from 'preact/hooks';
import { type Key, t } from '../../i18n';
import { complain, mayProgram, robot } from '../../state/cell';
import { goodName, isPlace, isTool, names, places, teach, values } from '../../state/points';
import { toast } from '../../state/toasts';
import { open } from '../../ui/ask';
import { Button, Field, Segmented, Select } from '../../ui/controls';
import { Dialog } from '../../ui/Dialog';
import { Icon, type IconName } from '../../ui/Icon';
import { type Compliance, kComplianceValues, parseCompliance, writeCompliance } from './compliance';
import { type Comparison, type Condition, parseCondition, writeCondition } from './condition';
import * as doc from './documents';
import { appendStatement, freeName, insertAfter, replaceStatement } from './edits';
import { clauseOf, kMoveWords, type Move, parseMove, type Statement, withClause, writeMove } from './statements';

// --- kinds

interface Kind {
  label: Key;
  icon: IconName;
  first: () => string;
}
const firstPlace = () => places.value[0]?.name ?? 'P1';
const firstPose = () => places.value.find((each) => each.kind === 'pose')?.name ?? 'pose()';
const firstFlag = () => names.value.find((each) => each.kind === 'tag' || each.kind === 'boolean')?.name ?? 'Ready';
/** Only for a robot with wheels. */
const kBaseKinds: Kind[] = [
  { label: 'step.kDrive', icon: 'up', first: () => 'drive 500mm' },
  { label: 'step.kDriveTo', icon: 'move', first: () => `drive ${firstPose()}` },
  { label: 'step.kTurn', icon: 'turnLeft', first: () => 'turn 90deg' },
];
const kKinds: Kind[] = [
  { label: 'step.kMovej', icon: 'move', first: () => `movej ${firstPlace()}` },
  { label: 'step.kMovel', icon: 'up', first: () => `movel ${firstPlace()}` },
  { label: 'step.kMovec', icon: 'turnRight', first: () => `movec ${firstPlace()}, ${places.value[1]?.name ?? firstPlace()}` },
  {
    label: 'step.kTouch',
    icon: 'hand',
    first: () => 'movel tool_offset(here(), z = 20mm), speed 10mm/s, touch, until force() > 10N',
  },
  { label: 'step.kWaitFor', icon: 'clock', first: () => `wait ${firstFlag()}` },
  { label: 'step.kWaitTime', icon: 'clock', first: () => 'wait 1s' },
  { label: 'step.kSet', icon: 'signals', first: () => `set ${firstFlag()} = true` },
  { label: 'step.kFor', icon: 'repeat', first: () => 'for i in 1 .. 3\nend' },
  { label: 'step.kRows', icon: 'repeat', first: () => 'for row in rows_of("parts.csv")\nend' },
  { label: 'step.kWhile', icon: 'repeat', first: () => `while ${firstFlag()}\nend` },
  { label: 'step.kIf', icon: 'layers', first: () => `if ${firstFlag()}\nend` },
  { label: 'step.kElse', icon: 'layers', first: () => `if ${firstFlag()}\nelse\nend` },
  { label: 'step.kAsk', icon: 'hand', first: () => 'wait user "Go on?"' },
  { label: 'step.kHold', icon: 'pause', first: () => 'hold "Look at the part"' },
  { label: 'step.kTrap', icon: 'alarm', first: () => `trap when ${firstFlag()}\nend` },
  { label: 'step.kEvery', icon: 'clock', first: () => 'every 500ms\nend' },
  { label: 'step.kPulse', icon: 'signals', first: () => `pulse ${firstFlag()} for 200ms` },
  { label: 'step.kComply', icon: 'hand', first: () => 'comply("z", force = 20N)' },
  { label: 'step.kStiff', icon: 'hand', first: () => 'stiff()' },
  { label: 'step.kLog', icon: 'edit', first: () => 'log "here"' },
  { label: 'step.kUse', icon: 'settings', first: () => 'use speed 50%' },
  { label: 'step.kLoad', icon: 'folder', first: () => 'load cycledata' },
  { label: 'step.kComment', icon: 'more', first: () => '# ' },
  { label: 'step.kOther', icon: 'program', first: () => '' },
];

/** Chooses the kind of a new step. It is inserted after the chosen step, else at the end. */
export function openStepKinds(after: Statement | null): void {
  open((close) => (
    <Dialog title={t('step.add')} wide onClose={close}>
      <div class="program-kinds">
        {(robot.value?.drives ? [...kBaseKinds, ...kKinds] : kKinds).map((kind) => (
          <button
            key={kind.label}
            type="button"
            onClick={() =>
              open((done) => <StepDialog title={t(kind.label)} first={kind.first()} action={t('step.insert')} onClose={done} onDone={(line) => insert(after, line)} />)
            }
          >
            <Icon name={kind.icon} />
            {t(kind.label)}
          </button>
        ))}
      </div>
    </Dialog>
  ));
}

function insert(after: Statement | null, line: string): void {
  const made = after ? insertAfter(doc.text.value, after, line) : appendStatement(doc.text.value, line);
  doc.change(made.text, made.line);
}

export function openStepForm(step: Statement): void {
  const first = step.word === '#' ? `# ${step.comment}` : step.text;
  open((close) => (
    <StepDialog
      title={t('step.edit', { line: step.line })}
      first={first}
      action={t('step.apply')}
      onClose={close}
      onDone={(line) => {
        const made = replaceStatement(doc.text.value, step.word === '#' ? { ...step, comment: '' } : step, line);
        doc.change(made.text, made.line);
      }}
    />
  ));
}

interface StepDialogProps {
  title: string;
  first: string;
  action: string;
  onClose: () => void;
  onDone: (line: string) => void;
}

function StepDialog({ title, first, action, onClose, onDone }: StepDialogProps) {
  const [line, setLine] = useState(first);
  const [head = '', ...tail] = line.split('\n');
  const setHead = (next: string) => setLine([next, ...tail].join('\n'));
  const done = () => {
    if (head.trim() === '') return;
    onClose();
    onDone(line);
  };
  return (
    <Dialog
      title={title}
      onClose={onClose}
      actions={
        <>
          <Button label={t('dialog.cancel')} onClick={onClose} />
          <Button label={action} tone="primary" disabled={head.trim() === ''} onClick={done} />
        </>
      }
    >
      <FormFor line={head} onChange={setHead} />
      <Field label={t('step.asText')} value={head} onInput={setHead} onEnter={done} />
    </Dialog>
  );
}

interface FormProps {
  line: string;
  onChange: (line: string) => void;
}

function FormFor({ line, onChange }: FormProps) {
  const text = line.trim();
  const move = parseMove(text);
  if (move) return <MoveForm move={move} onChange={(next) => onChange(writeMove(next))} />;
  const head = /^(while|if|elif|when)\s+(.*)$/i.exec(text);
  if (head) return <ConditionForm text={head[2]!} onChange={(next) => onChange(`${head[1]} ${next}`)} />;
  const count = /^for\s+(\w+)\s+in\s+(\S+)\s*\.\.\s*(\S+)$/i.exec(text);
  if (count)
    return (
      <Field label={t('step.times')} value={count[3]!} numeric onInput={(n) => onChange(`for ${count[1]} in ${count[2]} .. ${n || '1'}`)} />
    );
  const wait = /^wait\s+(.*)$/i.exec(text);
  if (wait) return <WaitForm rest={wait[1]!} onChange={(next) => onChange(`wait ${next}`)} />;
  const set = /^set\s+([\w.[\]]+)\s*=?\s*(.*)$/i.exec(text);
  if (set) return <SetForm name={set[1]!} value={set[2]!} onChange={(name, value) => onChange(`set ${name} = ${value}`)} />;
  const said = /^(log|hold)\s*\(?\s*"([^"]*)"\s*\)?$/i.exec(text) ?? /^(wait user)\s*"([^"]*)"$/i.exec(text);
  if (said)
    return <Field label={t('step.says')} value={said[2]!} onInput={(words) => onChange(`${said[1]} "${words.replaceAll('"', "'")}"`)} />;
  const compliance = parseCompliance(text);
  if (compliance) return <ComplianceForm compliance={compliance} onChange={(next) => onChange(writeCompliance(next))} />;
  return null;
}

// --- forces

function ComplianceForm({ compliance, onChange }: { compliance: Compliance; onChange: (compliance: Compliance) => void }) {
  const put = (name: string, value: string) => onChange({ ...compliance, values: { ...compliance.values, [name]: value } });
  return (
    <>
      <Field label={t('step.axes')} value={compliance.axes} onInput={(axes) => onChange({ ...compliance, axes: axes.replaceAll('"', '') })} />
      <div class="program-two">
        {kComplianceValues.map((name) => (
          <Field key={name} label={t(`step.c_${name}` as Key)} value={compliance.values[name] ?? ''} placeholder={t('step.usual')} onInput={(value) => put(name, value)} />
        ))}
      </div>
    </>
  );
}

// --- moves

const kExpression = '…';

function MoveForm({ move, onChange }: { move: Move; onChange: (move: Move) => void }) {
  const clause = (word: string) => clauseOf(move, word);
  const put = (word: string, value: string | null) => onChange(withClause(move, word, value));
  return (
    <>
      <Segmented
        label={t('step.how')}
        value={move.word}
        options={kMoveWords
          .filter((word) => word !== 'moveto' || move.word === 'moveto')
          .map((word) => ({ id: word, name: t(`step.w_${word}` as Key) }))}
        onChange={(word) => onChange({ ...move, word, via: word === 'movec' ? move.via || move.target : '' })}
      />
      {move.word === 'movec' && <PlaceField label={t('step.via')} value={move.via} onChange={(via) => onChange({ ...move, via })} />}
      <PlaceField label={t('step.to')} value={move.target} onChange={(target) => onChange({ ...move, target })} />
      <div class="program-two">
        <Choice label={t('step.speed')} value={clause('speed')} options={['10%', '25%', '50%', '75%', '100mm/s', '250mm/s']} none={t('step.fullSpeed')} onChange={(v) => put('speed', v)} />
        <Choice label={t('step.blend')} value={clause('blend')} options={['5mm', '10mm', '20mm', '50mm']} none={t('step.exact')} onChange={(v) => put('blend', v)} />
      </div>
      {move.word !== 'movej' && move.word !== 'moveto' ? null : <p class="note">{t('step.jointNote')}</p>}
    </>
  );
}

/** A choice of one of the usual values, none, or the present value. */
function Choice(props: { label: string; value: string | null; options: string[]; none: string; onChange: (value: string | null) => void }) {
  const all = props.value !== null && !props.options.includes(props.value) ? [props.value, ...props.options] : props.options;
  return (
    <Select
      label={props.label}
      value={props.value ?? ''}
      options={[{ id: '', name: props.none }, ...all.map((each) => ({ id: each, name: each }))]}
      onChange={(id) => props.onChange(id === '' ? null : id)}
    />
  );
}

function PlaceField({ label, value, onChange }: { label: string; value: string; onChange: (value: string) => void }) {
  const known = places.value.map((each) => each.name);
  const tools = values.value.filter(isTool).map((each) => each.name);
  const others = names.value.filter((each) => isPlace(each.kind) && !known.includes(each.name) && !tools.includes(each.name)).map((each) => each.name);
  const all = [...known, ...others];
  const [free, setFree] = useState(value !== '' && !all.includes(value));
  return (
    <div class="program-place">
      {!free && (
        <Select
          label={label}
          value={all.includes(value) ? value : kExpression}
          options={[...all.map((id) => ({ id, name: id })), { id: kExpression, name: t('step.expression') }]}
          onChange={(id) => (id === kExpression ? setFree(true) : onChange(id))}
        />
      )}
      {free && <Field label={label} value={value} onInput={onChange} />}
      <TeachHere taken={all} onTaught={(name) => (setFree(false), onChange(name))} />
    </div>
  );
}

/** Teaches a new point at the robot's present position. */
function TeachHere({ taken, onTaught }: { taken: string[]; onTaught: (name: string) => void }) {
  const [name, setName] = useState<string | null>(null);
  if (name === null)
    return (
      <Button label={t('step.teachHere')} icon="pin" disabled={!mayProgram.value} onClick={() => setName(freeName('P', [...taken, ...values.value.map((each) => each.name)]))} />
    );
  const problem = name === '' || goodName(name) ? (taken.includes(name) ? t('points.exists') : '') : t('points.badName');
  const go = async () => {
    if (problem || name === '') return;
    try {
      await teach({ name, robot: robot.value?.name ?? '', kind: 'pose' });
      toast({ kind: 'ok', text: t('points.taught', { name }) });
      onTaught(name);
      setName(null);
    } catch (error) {
      complain(error);
    }
  };
  return (
    <div class="program-teach">
      <Field label={t('step.newName')} value={name} problem={problem} onInput={setName} onEnter={() => void go()} />
      <Button label={t('points.teach')} icon="pin" tone="good" disabled={name === '' || problem !== ''} onClick={() => void go()} />
    </div>
  );
}

// --- conditions, waits, values

const kComparisons: Comparison[] = ['true', 'false', '==', '!=', '<', '<=', '>', '>='];

function valueNames(): string[] {
  return names.value.filter((each) => !isPlace(each.kind) && !['robot', 'tool', 'frame'].includes(each.kind)).map((each) => each.name);
}

function ConditionForm({ text, onChange }: { text: string; onChange: (text: string) => void }) {
  const condition = parseCondition(text);
  if (!condition) return <Field label={t('step.condition')} value={text} onInput={onChange} />;
  const all = valueNames();
  const put = (next: Partial<Condition>) => onChange(writeCondition({ ...condition, ...next }));
  const options = all.includes(condition.name) ? all : [condition.name, ...all];
  const how = (id: Comparison) => (id === 'true' ? t('step.isTrue') : id === 'false' ? t('step.isFalse') : id);
  return (
    <div class="program-two">
      <Select label={t('step.signal')} value={condition.name} options={options.map((id) => ({ id, name: id }))} onChange={(name) => put({ name })} />
      <Select label={t('step.is')} value={condition.how} options={kComparisons.map((id) => ({ id, name: how(id) }))} onChange={(id) => put({ how: id as Comparison })} />
      {condition.how !== 'true' && condition.how !== 'false' && <Field label={t('step.value')} value={condition.value} onInput={(value) => put({ value })} />}
    </div>
  );
}

function WaitForm({ rest, onChange }: { rest: string; onChange: (rest: string) => void }) {
  const time = /^(time\s+)?(\d[\w.]*)$/i.exec(rest);
  if (time) return <Field label={t('step.howLong')} value={time[2]!} onInput={(v) => onChange(`${time[1] ?? ''}${v || '1s'}`)} />;
  const ask = /^(user|input)\s*"([^"]*)"$/i.exec(rest);
  if (ask) return <Field label={t('step.says')} value={ask[2]!} onInput={(words) => onChange(`${ask[1]} "${words.replaceAll('"', "'")}"`)} />;
  const parts = /^(.*?)(?:,?\s+timeout\s+(.*?))?(\s+else)?$/i.exec(rest)!;
  const [, condition = '', limit = '', hanging = ''] = parts;
  const put = (c: string, l: string) => onChange(`${c}${l ? ` timeout ${l}` : ''}${hanging}`);
  return (
    <>
      <ConditionForm text={condition} onChange={(c) => put(c, limit)} />
      <Field label={t('step.limit')} value={limit} placeholder={t('step.noLimit')} onInput={(l) => put(condition, l)} />
    </>
  );
}

function SetForm({ name, value, onChange }: { name: string; value: string; onChange: (name: string, value: string) => void }) {
  const all = valueNames();
  const flag = /^(true|false)$/i.test(value);
  return (
    <>
      <Select
        label={t('step.signal')}
        value={name}
        options={(all.includes(name) ? all : [name, ...all]).map((id) => ({ id, name: id }))}
        onChange={(id) => onChange(id, value || 'true')}
      />
      {flag && (
        <Segmented<string>
          label={t('step.value')}
          value={value.toLowerCase()}
          options={[
            { id: 'true', name: t('step.on') },
            { id: 'false', name: t('step.off') },
          ]}
          onChange={(id) => onChange(name, id)}
        />
      )}
      <Field label={flag ? t('step.orValue') : t('step.value')} value={value} onInput={(v) => onChange(name, v)} />
    </>
  );
}

