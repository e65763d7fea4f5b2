/**
 * Puts the cell's English sentences into Spanish: by the rows of sentences.ts, and by files.ts for codes of files.
 * Loaded only while the page speaks Spanish.
 */
import { files } from './files';
import { advices, parts, sentences } from './sentences';

type Rows = readonly (readonly [string, string])[];

/** The rows with their patterns; those with more letters of their own come first. */
function patterns(rows: Rows): [RegExp, string][] {
  const own = (text: string) => text.replace(/\{\d\}/g, '').length;
  return [...rows]
    .sort(([a], [b]) => own(b) - own(a))
    .map(([from, to]) => [new RegExp(`^${from.replace(/[.*+?^$()|[\]\\/]/g, '\\$&').replace(/\{(?!\d\})/g, '\\{').replace(/\{\d\}/g, '(.+?)')}$`, 's'), to]);
}
const kSentences = patterns(sentences);
const kAdvices = patterns(advices);

/** A variable part: names stay as they are, types and places are translated. */
const part = (text: string): string => parts.reduce((now, [from, to]) => now.replace(from, to), text);

/** False for words that would stay English: the row is meant for another sentence. */
const isPart = (text: string): boolean => !/\s/.test(text) || part(text) !== text || /^['"`\d[(]/.test(text) || /[,=(){}[\]]/.test(text);

function put(rows: [RegExp, string][], text: string): string | null {
  for (const [pattern, to] of rows) {
    const found = pattern.exec(text);
    if (found && found.slice(1).every(isPart)) return to.replace(/\{(\d)\}/g, (_, index: string) => part(found[Number(index)]!));
  }
  return null;
}

/** The sentence in Spanish; null if no row has it. */
export function sentenceOf(own: string): string | null {
  const near = /; did you mean '(.+?)'(, in Latin letters)?\?$/.exec(own);
  const text = put(kSentences, near ? own.slice(0, near.index) : own);
  if (text === null || !near) return text;
  return `${text}; ¿quería decir «${near[1]}»${near[2] ? ', en letras latinas' : ''}?`;
}

/** Each clause of an advice by itself where the whole is not known; null if one of them is not. */
export function adviceOf(own: string): string | null {
  const whole = put(kAdvices, own);
  const text = whole ?? own.split('; ').map((each) => put(kAdvices, each)).reduce<string | null>((all, each) => (all === null || each === null ? null : `${all}; ${each}`), '')?.slice(2) ?? null;
  return text && text.charAt(0).toUpperCase() + text.slice(1);
}

/** The sentence of a code that only files have. */
export const fileCode = (code: string): string | undefined => files[code];
