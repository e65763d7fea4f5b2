/**
 * Puts the cell's English sentences into Spanish: by the rows of sentences.ts, and by files.ts for codes of files.
 * Loaded only while the page speaks Spanish.
 */
import { files } from './files';
import { advices, parts, sentences, wholeParts } from './sentences';

type Rows = readonly (readonly [string, string])[];

interface Row {
  pattern: RegExp;
  to: string;
  /** For each variable part: it stands in quotes, so it can be any name. */
  quoted: boolean[];
}

/** The rows with their patterns; those with more letters of their own come first. */
function patterns(rows: Rows): Row[] {
  const own = (text: string) => text.replace(/\{\d\}/g, '').length;
  const plain = (text: string) => text.replace(/[.*+?^$()|[\]\\/]/g, '\\$&').replace(/\{(?!\d\})/g, '\\{').replace(/\{\d\}/g, '(.+?)');
  return [...rows]
    .sort(([a], [b]) => own(b) - own(a))
    .map(([from, to]) => ({ pattern: new RegExp(`^${plain(from)}$`, 's'), to, quoted: [...from.matchAll(/('?)\{\d\}/g)].map(([, quote]) => quote !== '') }));
}
const kSentences = patterns(sentences);
const kAdvices = patterns(advices);

const kQuoted = /(`[^`]*`|"[^"]*"|'[^']*')/;
const outside = (text: string): string => parts.reduce((now, [from, to]) => now.replace(from, to), text);

/** A variable part: names and code stay as they are, types and places are translated. */
function part(text: string): string {
  const whole = wholeParts.reduce((now, [from, to]) => now.replace(from, to), text);
  return whole.split(kQuoted).map((each, i) => (i % 2 === 0 ? outside(each) : each.replace(/^'(.+)'$/, '«$1»'))).join('');
}

/** False for words that would stay English: the row is meant for another sentence. */
function isPart(text: string): boolean {
  const bare = text.replace(new RegExp(kQuoted, 'g'), '');
  return !/[a-z]{2,} [a-z]{2,}/.test(bare) || part(text) !== text.replace(/'([^']+)'/g, '«$1»') || /[=(){}[\]]/.test(bare);
}

function put(rows: Row[], text: string): string | null {
  for (const { pattern, to, quoted } of rows) {
    const found = pattern.exec(text)?.slice(1);
    if (!found?.every((each, i) => quoted[i] || isPart(each))) continue;
    const out = to.replace(/\{(\d)\}/g, (_, index: string) => (quoted[Number(index) - 1] ? found[Number(index) - 1]! : part(found[Number(index) - 1]!)));
    return out.replace(/\bde el /g, 'del ').replace(/\ba el /g, 'al ');
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
