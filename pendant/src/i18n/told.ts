/**
 * What the cell tells in English for terminals, as the page says it: by code and values in the page's
 * language, without advice to type commands. Without a text for the code, the cell's own words are shown.
 */
import {type Key, language, number, t, word} from '.';
import {jointText} from '../ui/format';
import { en } from './en';

/** Values of a sentence. The name of a number ends with its unit: depth_m, moved_rad, time_s. */
export type Facts = Record<string, string|number>;

export interface Problem {
  code: string;
  what: string;
  advice?: string;
  facts?: Facts;
}

/** Of a request that was refused, or of what else was thrown. */
export const problemOf = (error: unknown): Problem => (error as {problem?: Problem}).problem ??
    {code: '', what: error instanceof Error ? error.message : String(error)};

export interface Told {
  text: string;
  /** What the cell said itself, where `text` does not say it. */
  detail: string;
  advice: string;
}

/** The sentence of these codes says all that matters: the cell's own words add only advice for a terminal. */
export const kSaysAll = new Set([
  'asked-already', 'discarded', 'disarmed', 'has-ended', 'held', 'moving', 'motion-held', 'no-cell',
  'no-control', 'no-fault', 'no-program', 'no-role', 'no-speed', 'not-asked', 'not-begun', 'not-held', 'not-paused',
  'nothing-to-step-back', 'overtaken', 'program-changed', 'program-runs', 'session-over', 'still-running', 'stopped',
  'stopping', 'wrong-state'
]);

/** What the page finds itself: there are no words of the cell for it. */
const kOfPage = new Set(['not-connected', 'no-answer']);

const known = (key: string): key is Key => key in en;

// --- values

/** `fixture table`, `part cube`: as contacts name bodies. */
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

/** By the names that texts use: without units, and `who` for what a fault blames. */
function namesOf(facts: Facts): Record<string, string> {
  const out = Object.fromEntries(Object.entries(facts).map(
      ([name, value]) => [name.replace(/_(m|rad|s)$/, ''), valueWords(name, value)]));
  const who = [facts.component ?? facts.controller, facts.interface].filter(Boolean).join(', ');
  return who ? {...out, who} : out;
}

/** The text of `key` with all its values; null where there is no such text, or a value of it is missing. */
function filled(key: string, names: Record<string, string>): string|null {
  if (!known(key)) return null;
  const lacks = [...en[key].matchAll(/\{(\w+)\}/g)].some(([, name]) => !(name! in names));
  return lacks ? null : t(key, names);
}

// --- causes and problems

/** Why the cell does not run, by its code; without one that is known, in the cell's own words. */
export function causeWords(code: string, own = '', facts: Facts = {}): string {
  if (code === 'none') return '';
  return filled(`cause.${code}`, namesOf(facts)) ??
      (known(`told.${code}`) ? t(`told.${code}` as Key) : plain(own || code));
}

/**
 * The sentence with the values that came with the code, the most exact one that they fill; null where the
 * page has none.
 */
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

/**
 * Returns the text of a problem. If the cell sent the values, the sentence of the code contains them. If not,
 * English shows the cell's own sentence; other languages show the sentence of the code, and the cell's below it
 * unless the sentence says all.
 */
export function problemWords({code, what, advice, facts = {}}: Problem): Told {
  const own = kOfPage.has(code) ? '' : plain(what);
  const remedy = [`do.${code}.${facts.doing}`, `do.${code}`].find(known);
  const todo = remedy ? t(remedy) : plain(advice ?? '');
  const whole = sentence(code, facts);
  if (whole !== null) {
    const reason = typeof facts.reason === 'string' ? plain(facts.reason) : '';
    return {text: whole, detail: whole.includes(reason) ? '' : reason, advice: todo};
  }
  const said = known(`told.${code}`) ? t(`told.${code}` as Key) : own || t('told.refused');
  const first = language.value === 'en' && own ? own : said;
  return {text: first, detail: first === own || kSaysAll.has(code) ? '' : own, advice: todo};
}

/** In one line, with what the cell said itself in brackets. */
export function problemLine(problem: Problem): string {
  const {text, detail} = problemWords(problem);
  return detail ? `${text} (${detail})` : text;
}

/** A line of the log. In English the cell's own words have everything. */
export function lineWords(line: {text: string; code?: string; facts?: Facts}): string {
  const own = plain(line.text);
  if (!line.code || language.value === 'en') return own;
  const whole = sentence(line.code, line.facts ?? {});
  if (whole !== null) return whole;
  if (!known(`told.${line.code}`)) return own;
  const said = t(`told.${line.code}` as Key);
  return kSaysAll.has(line.code) ? said : `${said} (${own})`;
}

// --- what only a terminal can do

// A path may hold the name, too: /home/me/polyarm-cells/arm.stl.
const kCommand = /(?<![\w./-])polyarm [a-z]+(?<!runs)\b|(?:^|[\s('`])--[a-z]|\btypes? ['`]/;

/** Without what only a terminal can do: each clause that says so goes. */
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
