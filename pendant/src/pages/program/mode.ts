/** The language mode for CodeMirror: colours and indentation, from the list of words. */
import { HighlightStyle, indentService, StreamLanguage, type StringStream, syntaxHighlighting } from '@codemirror/language';
import { tags } from '@lezer/highlight';
import type { Language } from './knownWords';
import { kMotionWords } from './statements';

interface State {
  /** True after the line's first word. */
  begun: boolean;
}

/** One mode for each list of words, because CodeMirror keeps every language that was ever defined. */
const made = new WeakMap<Language, StreamLanguage<State>>();

export function mode(language: Language): StreamLanguage<State> {
  let out = made.get(language);
  if (!out) made.set(language, (out = define(language)));
  return out;
}

function define(language: Language): StreamLanguage<State> {
  const roles = new Map(language.words.map((each) => [each.name, each.role]));
  const functions = new Set(language.functions.map((each) => each.name));
  const moves = new Set(kMotionWords);

  function wordToken(name: string, first: boolean, called: boolean): string {
    const role = roles.get(name);
    if (first && moves.has(name)) return 'typeName';
    if (first && (role === 'statement' || role === 'branch' || role === 'closer')) return 'keyword';
    if (role === 'closer' || role === 'branch') return 'keyword';
    if (role === 'reserved') return name === 'true' || name === 'false' ? 'bool' : 'operatorKeyword';
    if (called && functions.has(name)) return 'function';
    if (!first && (role === 'clause' || /^(timeout|in|time|user|error|start)$/.test(name))) return 'modifier';
    return 'variableName';
  }

  function token(stream: StringStream, state: State): string | null {
    if (stream.sol()) state.begun = false;
    if (stream.eatSpace()) return null;
    if (stream.match(/^#.*/)) return 'comment';
    const first = !state.begun;
    state.begun = true;
    if (stream.match(/^"(?:[^"\\]|\\.)*"?/)) return 'string';
    if (stream.match(/^`[^`]*`?/)) return 'variableName';
    if (stream.match(/^\d+(?:\.\d+)?(?:e[-+]?\d+)?(?:%|[a-zA-Z]+(?:\/[a-z]+\d?)?)?/)) return 'number';
    const name = stream.match(/^[A-Za-z_]\w*/) as RegExpMatchArray | null;
    if (name) return wordToken(name[0].toLowerCase(), first, stream.peek() === '(');
    if (stream.match(/^(==|!=|<=|>=|\.\.|[-+*/^=<>])/)) return 'operator';
    stream.next();
    return null;
  }

  return StreamLanguage.define<State>({
    name: 'polyarm',
    startState: () => ({ begun: false }),
    copyState: (state) => ({ ...state }),
    token,
    languageData: { commentTokens: { line: '#' }, indentOnInput: /^\s*(end\w*|else|elif)$/ },
    tokenTable: { modifier: tags.modifier, function: tags.function(tags.variableName) },
  });
}

/** Uses the colour variables of the page, which exist in both themes. */
export const colours = syntaxHighlighting(
  HighlightStyle.define([
    { tag: tags.keyword, color: 'var(--code-keyword)', fontWeight: '600' },
    { tag: tags.typeName, color: 'var(--code-move)', fontWeight: '700' },
    { tag: tags.modifier, color: 'var(--code-clause)' },
    { tag: tags.operatorKeyword, color: 'var(--code-keyword)' },
    { tag: tags.bool, color: 'var(--code-number)' },
    { tag: tags.number, color: 'var(--code-number)' },
    { tag: tags.string, color: 'var(--code-text)' },
    { tag: tags.comment, color: 'var(--muted)', fontStyle: 'italic' },
    { tag: tags.function(tags.variableName), color: 'var(--code-function)' },
    { tag: tags.variableName, color: 'var(--text)' },
    { tag: tags.operator, color: 'var(--muted)' },
  ]),
);

/** Indents a line by two blanks after a line that opens a block, and back for a line that ends a block. */
export const indents = indentService.of((context, pos) => {
  const doc = context.state.doc;
  const line = doc.lineAt(pos);
  const broken = context.simulatedBreak === pos;
  let number = broken ? line.number : line.number - 1;
  let text = broken ? line.text.slice(0, pos - line.from) : doc.line(Math.max(1, number)).text;
  while (number > 1 && text.trim() === '') text = doc.line(--number).text;
  if (number < 1) return 0;
  text = text.replace(/#.*/, '').trimEnd();
  const after = broken ? line.text.slice(pos - line.from) : line.text;
  const own = /^\s*/.exec(text)![0].length;
  const opens = /^\s*((while|for|if|elif|else|func|try|task|together|when|trap|every|lock|test)\b|on\s+(stop|error)\b)|\belse$/i.test(text);
  const closes = /^\s*(end\w*|else|elif|on\s+error)\b/i.test(after);
  return Math.max(0, own + (opens ? 2 : 0) - (closes ? 2 : 0));
});
