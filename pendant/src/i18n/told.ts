/** What the cell tells in English for terminals, as the page says it: by code in the page's language, without advice to type commands. */
import { type Key, language, t } from '.';
import { en } from './en';

/** Beginnings of the causes as `control::name(StopCause)` tells them; a test compares the list with that. */
export const causes: [RegExp, Key][] = [
  [/^a stop was asked for/, 'cause.asked'],
  [/^wall time went missing/, 'cause.gap'],
  [/^the cell thread was silent/, 'cause.cellSilent'],
  [/^a hardware component failed/, 'cause.component'],
  [/^a controller failed/, 'cause.controller'],
  [/^the program ended/, 'cause.programEnded'],
  [/^cycles were late/, 'cause.late'],
  [/^a measured joint position is no number/, 'cause.notANumber'],
  [/^a measured joint position jumped/, 'cause.jump'],
  [/^a joint does not follow/, 'cause.notFollowing'],
  [/^a joint is far outside/, 'cause.limits'],
  [/contact|touched/, 'cause.contact'],
];

/** A cause of a stop in the page's language, by its code where that is told; what no table knows stays as it is. */
export function causeWords(cause: string, code = ''): string {
  if (code === 'contact') return t('cause.contact');
  const found = causes.find(([beginning]) => beginning.test(cause));
  return found ? t(found[1]) : plain(cause);
}

export const ofContact = (cause: string) => /contact|touched/.test(cause);

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

const known = (key: string): key is Key => key in en;

export interface Told {
  text: string;
  /** What the cell said itself, with numbers and names. */
  detail: string;
  advice: string;
}

/** A problem by its code: in English as the cell says it, else the sentence of the code with the cell's own below it. */
export function problemWords(problem: { code: string; what: string; advice?: string }): Told {
  const own = plain(problem.what);
  const [name, remedy] = [`told.${problem.code}`, `do.${problem.code}`];
  const said = known(name) ? t(name) : own || t('told.refused');
  const first = language.value === 'en' && own ? own : said;
  const advice = known(remedy) ? t(remedy) : plain(problem.advice ?? '');
  return { text: first, detail: first === own ? '' : own, advice };
}
