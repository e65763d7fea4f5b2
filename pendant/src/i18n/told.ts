/**
 * Translates what the cell reports in English for terminals into the page's language, by code and values and
 * without advice to type commands. If a code has no text, the cell's own words are shown.
 */
import { effect, signal } from '@preact/signals';
import {type Key, language, languageLoaded, number, t, word} from '.';
import {jointText} from '../ui/format';
import { deviceWords } from './device';
import { en } from './en';

/** Values of a sentence. The name of a number ends with its unit: depth_m, moved_rad, time_s. */
export type Facts = Record<string, string|number>;

export interface Problem {
  code: string;
  what: string;
  advice?: string;
  facts?: Facts;
}

/** The problem of a refused request, or of any other thrown value. */
export const problemOf = (error: unknown): Problem => (error as {problem?: Problem}).problem ??
    {code: '', what: error instanceof Error ? error.message : String(error)};

export interface Told {
  text: string;
  /** The cell's own words, if `text` does not contain them. */
  detail: string;
  advice: string;
}

/** Codes whose sentence is complete. The cell's own words would only add advice for a terminal. */
export const kSaysAll = new Set([
  'answered-already', 'asked-already', 'discarded', 'disarmed', 'has-ended', 'held', 'moving', 'motion-held', 'no-cell',
  'no-control', 'no-fault', 'no-points-file', 'no-program', 'no-role', 'no-speed', 'not-asked', 'not-begun', 'not-held', 'not-paused',
  'nothing-to-step-back', 'overtaken', 'program-changed', 'program-runs', 'session-over', 'still-running', 'stopped',
  'stopping', 'wrong-state'
]);

/** Problems that the page itself finds. The cell has no words for them. */
const kOfPage = new Set(['not-connected', 'no-answer']);

const known = (key: string): key is Key => key in en;

/** The tables for sentences of programs and files. Only Spanish has them, and loads them when it is chosen. */
const tables = signal<typeof import('./es/match')|null>(null);
export async function tablesLoaded(): Promise<void> {
  await languageLoaded();
  if (language.value === 'es' && !tables.peek()) tables.value = await import('./es/match');
}
effect(() => {
  if (language.value === 'es') void tablesLoaded().catch(() => undefined);
});
const translated = () => (language.value === 'es' ? tables.value : null);

// --- values

/** The words for a body as contacts name it: `fixture table`, `part cube`. */
export function bodyWords(name: string): string {
  const found = /^(fixture|part|the part held by) (.+)$/.exec(name);
  if (found)
    return t(
        ({fixture: 'body.fixture', part: 'body.part'} as Record<string, Key>)[found[1]!] ?? 'body.held',
        {name: found[2]!});
  return name === 'floor' || name === 'something' ? t(`body.${name}`) : name;
}

function numberWords(value: number, unit: string): string {
  if (unit === 'm' || unit === 'rad') return jointText(value, unit);
  return unit === 's' ? `${number(value, 2)} s` : String(value);
}

function valueWords(name: string, value: string|number): string {
  if (typeof value === 'number') return numberWords(value, /_(m|rad|s)$/.exec(name)?.[1] ?? '');
  if (name === 'cause') return causeWords(value);
  if (name === 'state') return word('state', value);
  return name === 'a' || name === 'b' ? bodyWords(value) : value;
}

/**
 * The values under the names that texts use: without units, and `who` for the component or controller at
 * fault.
 */
function namesOf(facts: Facts): Record<string, string> {
  const out = Object.fromEntries(Object.entries(facts).map(
      ([name, value]) => [name.replace(/_(m|rad|s)$/, ''), valueWords(name, value)]));
  const who = [facts.component ?? facts.controller, facts.interface].filter(Boolean).join(', ');
  return who ? {...out, who} : out;
}

/** The text of `key` with all its values; null if there is no such text, or if a value is missing. */
function filled(key: string, names: Record<string, string>): string|null {
  if (!known(key)) return null;
  const lacks = [...en[key].matchAll(/\{(\w+)\}/g)].some(([, name]) => !(name! in names));
  return lacks ? null : t(key, names);
}

// --- causes and problems

/** Why the cell does not run. If the code is unknown, the cell's own words. */
export function causeWords(code: string, own = '', facts: Facts = {}): string {
  if (code === 'none') return '';
  return filled(`cause.${code}`, namesOf(facts)) ??
      (known(`told.${code}`) ? t(`told.${code}` as Key) : plain(own || code));
}

/** The most specific sentence of the code for which all values are present; null if the page has none. */
function sentence(code: string, facts: Facts): string|null {
  const names = namesOf(facts);
  const variants = [
    facts.doing, ...['tcp', 'who', 'cause'].filter((each) => each in names)
  ].filter(Boolean).map((each) => `with.${code}.${each}`);
  for (const key of [...variants, `with.${code}`]) {
    const text = filled(key, names);
    if (text !== null) return text;
  }
  return null;
}

/** The robots whose own controllers interpolate, and whether these are all robots: nobody jogs them here. */
export const forwardRobots = signal<{names: readonly string[]; all: boolean}>({names: [], all: false});

/** True if the problem is one of such a robot. */
function isForward(facts: Facts): boolean {
  const {names, all} = forwardRobots.value;
  const of = [facts.robot, facts.a, facts.b, facts.joint].filter((each): each is string => typeof each === 'string');
  return all || names.some((name) => of.some((each) => each === name || each.startsWith(`${name}/`)));
}

/**
 * The text of a problem. If the cell sent the values, it is the sentence of the code with the values.
 * Otherwise English shows the cell's own sentence; other languages show the sentence of the code, and the
 * cell's sentence below it unless the code is in kSaysAll.
 */
export function problemWords({code, what, advice, facts = {}}: Problem): Told {
  const own = kOfPage.has(code) ? '' : plain(what);
  const byOthers = isForward(facts) ? [`do.${code}.forward`] : [];
  const remedy = [...byOthers, `do.${code}.${facts.doing}`, `do.${code}`].find(known);
  const todo = remedy ? t(remedy) : adviceWords(plain(advice ?? ''));
  const whole = sentence(code, facts);
  if (whole !== null) {
    const reason = typeof facts.reason === 'string' ? deviceWords(plain(facts.reason)) : '';
    return {text: whole, detail: whole.includes(reason) ? '' : reason, advice: todo};
  }
  const row = translated()?.sentenceOf(own);
  if (row) return {text: row, detail: '', advice: todo};
  const said = codeWords(code) ?? (own || t('told.refused'));
  const first = language.value === 'en' && own ? own : said;
  const detail = code === 'component-failed' ? deviceWords(own) : own;
  return {text: first, detail: first === own || kSaysAll.has(code) ? '' : detail, advice: todo};
}

/**
 * A finding of a check. Its advice is for the file, not for a cell that runs: the cell's own advice.
 */
export const findingWords = (found: Problem): Told =>
    ({...problemWords(found), advice: adviceWords(plain(found.advice ?? ''))});

/** The sentence of the code; undefined: it has no sentence. */
const codeWords = (code: string): string|undefined =>
    known(`told.${code}`) ? t(`told.${code}` as Key) : translated()?.fileCode(code);

/** Advice of the cell, which has no code. */
const adviceWords = (own: string): string => (own && translated()?.adviceOf(own)) || own;

/** A sentence of the cell without a code. */
export const ownWords = (own: string): string => translated()?.sentenceOf(plain(own)) ?? plain(own);

/** The problem in one line, with the cell's own words in brackets. */
export function problemLine(problem: Problem): string {
  const {text, detail} = problemWords(problem);
  return detail ? `${text} (${detail})` : text;
}

/** A line of the log. English shows the cell's own words, which are complete. */
export function lineWords(line: {text: string; code?: string; facts?: Facts}): string {
  const own = plain(line.text);
  if (!line.code || language.value === 'en') return own;
  const whole = sentence(line.code, line.facts ?? {});
  if (whole !== null) return whole;
  const row = translated()?.sentenceOf(own);
  if (row) return row;
  const said = codeWords(line.code);
  if (said === undefined) return own;
  return kSaysAll.has(line.code) ? said : `${said} (${own})`;
}

// --- questions of a program

/** The second line of a question: the default answer, or why the last answer was refused. */
export function noteWords(note: string): string {
  const usual = /^Enter alone means (.+)$/s.exec(note);
  if (usual) return t('question.enter', {value: usual[1]!});
  const refused = /^the answer is .+, such as (.+)$/s.exec(note);
  return refused ? t('question.refused', {value: refused[1]!}) : plain(note);
}

// --- advice for a terminal

// The lookbehind excludes paths such as /home/me/polyarm-cells/arm.stl.
const kCommand = /(?<![\w./-])polyarm [a-z]+(?<!runs)\b|(?:^|[\s('`])--[a-z]|\btypes? ['`]/;

/** Removes each clause with advice that only works at a terminal. */
export function plain(text: string): string {
  if (!kCommand.test(text)) return text;
  const outside = text.replace(/\s*\(([^()]*)\)/g, (whole, inside: string) => {
    const left = clauses(inside);
    return left === inside ? whole : left ? ` (${left})` : '';
  });
  return clauses(outside);
}

function clauses(text: string): string {
  if (!kCommand.test(text)) return text;
  return text
    .split(/(?<=[;.:])\s+|,\s+(?=or\b|then\b|polyarm\b|--)/)
    .filter((each, i, all) => !kCommand.test(each) && !(each.endsWith(':') && kCommand.test(all[i + 1] ?? '')))
    .join(' ')
    .replace(/[;:,\s]+$/, '')
    .replace(/^or /, '');
}
