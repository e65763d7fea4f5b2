/** Describes a statement in words, for the list of steps. */
import { type Key, t } from '../../i18n';
import type { IconName } from '../../ui/Icon';
import { type Compliance, parseCompliance } from './compliance';
import { kMoveWords, kSpeedWords, parseMove, type Statement } from './statements';

export interface Sentence {
  icon: IconName;
  text: string;
  /** The clauses of a move. */
  chips: string[];
}

const kPlain: Record<string, [IconName, Key]> = {
  load: ['folder', 'step.load'],
  import: ['folder', 'step.load'],
  include: ['folder', 'step.include'],
  log: ['edit', 'step.log'],
  let: ['plus', 'step.let'],
  set: ['signals', 'step.set'],
  use: ['settings', 'step.use'],
  while: ['repeat', 'step.while'],
  for: ['repeat', 'step.for'],
  if: ['layers', 'step.if'],
  elif: ['layers', 'step.elif'],
  else: ['layers', 'step.else'],
  func: ['program', 'step.func'],
  return: ['left', 'step.return'],
  break: ['right', 'step.break'],
  continue: ['repeat', 'step.continue'],
  stop: ['stop', 'step.stop'],
  hold: ['pause', 'step.hold'],
  try: ['layers', 'step.try'],
  raise: ['alarm', 'step.raise'],
  retry: ['repeat', 'step.retry'],
  task: ['layers', 'step.task'],
  together: ['layers', 'step.together'],
  meet: ['link', 'step.meet'],
  lock: ['lock', 'step.lock'],
  when: ['signals', 'step.when'],
  trap: ['alarm', 'step.trap'],
  every: ['clock', 'step.every'],
  pulse: ['signals', 'step.pulse'],
  turn: ['turnLeft', 'step.turn'],
};
const kMoves: Record<string, Key> = {
  moveto: 'step.moveto',
  movej: 'step.movej',
  movel: 'step.movel',
  movec: 'step.movec',
  speedj: 'step.speedj',
  speedl: 'step.speedl',
};
/** Calls of functions that read as statements. */
const kCalls: Record<string, [IconName, Key]> = {
  comply: ['hand', 'step.comply'],
  stiff: ['hand', 'step.stiff'],
};
/** What a name is, as `program.names` lists it: `pose`, `number` …; '' if unknown. */
export type KindOf = (name: string) => string;
const kUnknown: KindOf = () => '';

/** Calls whose value is a pose. */
const kPoseCall = /^(pose|quat|offset|tool_offset|with|inverse|interpolate|here|fk)\s*\(/i;

/** True if a base that drives there goes to a pose; false if it drives by a length. */
function isPose(target: string, kindOf: KindOf): boolean {
  return kPoseCall.test(target) || (/^`[^`]+`$|^[A-Za-z_]\w*$/.test(target) && kindOf(target.replaceAll('`', '')) === 'pose');
}

/** The kinds of names that a program may use: those of the cell, and the poses that the program itself names. */
export function kindsIn(statements: readonly Statement[], names: readonly { name: string; kind: string }[]): KindOf {
  const kinds = new Map(names.map((each) => [each.name, each.kind]));
  for (const { text } of statements) {
    const [, name, value] = /^let\s+(\w+)\s*=\s*(.*)$/i.exec(text) ?? [];
    if (name) kinds.set(name, kPoseCall.test(value!) ? 'pose' : '');
  }
  return (name) => kinds.get(name) ?? '';
}

/** Every statement that has a sentence here. */
export const kSaid = [...Object.keys(kPlain), ...Object.keys(kMoves), 'wait', 'on', 'drive'];

export function sentenceOf(statement: Statement, kindOf: KindOf = kUnknown): Sentence {
  const { word, text } = statement;
  const rest = text.slice(word.length).trim();
  if (word === '#') return { icon: 'more', text: statement.comment || '#', chips: [] };
  if (statement.closes) return { icon: 'up', text: t('step.end'), chips: [] };
  if (word in kMoves) {
    const move = parseMove(text, [...kMoveWords, ...kSpeedWords])!;
    const chips = move.clauses.map((each) => [each.word, each.value].filter(Boolean).join(' '));
    return { icon: word === 'movel' ? 'up' : word === 'movec' ? 'turnRight' : 'move', text: t(kMoves[word]!, { target: move.target, via: move.via }), chips };
  }
  if (word === 'wait') return waitSentence(rest);
  if (word === 'on') return { icon: 'alarm', text: t(/^stop/i.test(rest) ? 'step.onStop' : 'step.onError'), chips: [] };
  if (word === 'drive') {
    const { target, clauses } = parseMove(text, [word])!;
    const to = isPose(target, kindOf);
    const chips = clauses.map((each) => [each.word, each.value].filter(Boolean).join(' '));
    return { icon: to ? 'move' : 'up', text: t(to ? 'step.driveTo' : 'step.drive', { rest: target }), chips };
  }
  const plain = kPlain[word];
  if (plain) return { icon: plain[0], text: t(plain[1], { rest: tidy(word, rest) }), chips: [] };
  const call = kCalls[word];
  const compliance = word === 'comply' ? parseCompliance(text) : null;
  if (call && (compliance || word === 'stiff'))
    return { icon: call[0], text: t(call[1], { axes: compliance?.axes ?? '' }), chips: chipsOf(compliance) };
  return { icon: 'program', text: t('step.call', { rest: text }), chips: [] };
}

function chipsOf(compliance: Compliance | null): string[] {
  return Object.entries(compliance?.values ?? {}).map(([name, value]) => `${name} ${value}`);
}

function tidy(word: string, rest: string): string {
  if (word === 'set') return rest.replace(/^([\w.[\]]+)\s+(?!=)(\S.*)$/, '$1 = $2');
  if (word === 'trap') return rest.replace(/^when\s+/i, '');
  if (word === 'log' || word === 'hold') return rest.replace(/^\((.*)\)$/, '$1');
  return rest;
}

function waitSentence(rest: string): Sentence {
  const [head = '', limit] = rest.replace(/\s+else$/i, '').split(/,?\s+timeout\s+/i);
  const chips = limit ? [t('step.timeout', { time: limit })] : [];
  if (/^(user|input)\b/i.test(head)) return { icon: 'hand', text: t('step.waitUser', { rest: head.replace(/^\w+\s*/, '') }), chips };
  const time = /^(?:time\s+)?(\d[\w.]*)$/i.exec(head);
  if (time) return { icon: 'clock', text: t('step.waitTime', { time: /[a-z]$/i.test(time[1]!) ? time[1]! : `${time[1]} s` }), chips };
  return { icon: 'clock', text: t('step.waitFor', { rest: head.replace(/^var\s+/i, '') }), chips };
}
