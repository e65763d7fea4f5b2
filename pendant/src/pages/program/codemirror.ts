/**
 * CodeMirror with the extensions for programs. A chunk of its own, loaded when a program is first shown as
 * text.
 */
import { autocompletion, closeBrackets, closeBracketsKeymap, type CompletionContext, type CompletionResult, completionKeymap } from '@codemirror/autocomplete';
import { defaultKeymap, history, historyKeymap, indentWithTab, toggleComment } from '@codemirror/commands';
import { bracketMatching, indentOnInput, indentUnit } from '@codemirror/language';
import { type Diagnostic, lintGutter, setDiagnostics } from '@codemirror/lint';
import { highlightSelectionMatches, search, searchKeymap } from '@codemirror/search';
import { type ChangeDesc, Compartment, EditorState, type Extension, RangeSet, StateEffect, StateField, type Text, Transaction } from '@codemirror/state';
import {
  Decoration, drawSelection, EditorView, gutter, GutterMarker, highlightActiveLine, keymap, lineNumbers,
} from '@codemirror/view';
import type { KnownName } from '../../wire/requests';
import { type LineMap, lineMap } from './breakpoints';
import { findingWords } from '../../i18n/told';
import type { Problem } from './documents';
import { colours, indents, mode } from './mode';
import type { Language } from './knownWords';

export interface EditorHooks {
  label: string;
  language: Language;
  names: () => KnownName[];
  phrases: Record<string, string>;
  onChange: (text: string, map: LineMap) => void;
  onLine: (line: number) => void;
  onBreakpoint: (line: number) => void;
}

// --- current lines and breakpoints

const setLive = StateEffect.define<number[]>();
const liveLine = Decoration.line({ class: 'cm-live' });
const live = StateField.define({
  create: () => Decoration.none,
  update(marks, change) {
    marks = marks.map(change.changes);
    for (const effect of change.effects)
      if (effect.is(setLive))
        marks = RangeSet.of(
          effect.value.filter((n) => n >= 1 && n <= change.state.doc.lines).map((n) => liveLine.range(change.state.doc.line(n).from)),
          true,
        );
    return marks;
  },
  provide: (field) => EditorView.decorations.from(field),
});

class Dot extends GutterMarker {
  constructor(private readonly kind: 'break' | 'live' | 'both') {
    super();
  }
  override eq(other: Dot): boolean {
    return other.kind === this.kind;
  }
  override toDOM(): Node {
    const out = document.createElement('span');
    out.className = `cm-mark ${this.kind}`;
    return out;
  }
}
const setBreaks = StateEffect.define<number[]>();
const breaks = StateField.define<Set<number>>({
  create: () => new Set(),
  update(lines, change) {
    for (const effect of change.effects) if (effect.is(setBreaks)) return new Set(effect.value);
    if (!change.docChanged || lines.size === 0) return lines;
    return new Set([...lines].map(linesMoved(change.startState.doc, change.changes, change.newDoc)).filter((line) => line > 0));
  },
});

/**
 * Maps the lines after a change. A line moves with its first character; if the whole line was replaced or
 * removed, the common parts of both texts decide.
 */
function linesMoved(before: Text, changes: ChangeDesc, after: Text): LineMap {
  let byText: LineMap | null = null;
  return (number) => {
    if (number > before.lines) return 0;
    const line = before.line(number);
    const from = line.from + /^\s*/.exec(line.text)![0].length;
    if (changes.touchesRange(from, line.to) !== 'cover') return after.lineAt(changes.mapPos(from, 1)).number;
    byText ??= lineMap(before.toString(), after.toString());
    return byText(number);
  };
}

const markGutter = (hooks: EditorHooks) =>
  gutter({
    class: 'cm-marks',
    lineMarker(view, block) {
      const line = view.state.doc.lineAt(block.from).number;
      let isLive = false;
      view.state.field(live).between(block.from, block.from, () => void (isLive = true));
      const stops = view.state.field(breaks).has(line);
      return stops || isLive ? new Dot(stops && isLive ? 'both' : stops ? 'break' : 'live') : null;
    },
    lineMarkerChange: (update) =>
      update.startState.field(breaks) !== update.state.field(breaks) || update.startState.field(live) !== update.state.field(live),
    renderEmptyElements: true,
    domEventHandlers: { mousedown: (view, block, event) => toggled(hooks, view, block.from, event as MouseEvent) },
  });

function toggled(hooks: EditorHooks, view: EditorView, at: number, event: MouseEvent): true {
  hooks.onBreakpoint(view.state.doc.lineAt(shownAt(view, event.clientY) ?? at).number);
  return true;
}

/**
 * The start of the line that is drawn at this height. Until CodeMirror has measured a newly opened text, it
 * underestimates the height of its lines, so a press would reach a later line.
 */
function shownAt(view: EditorView, y: number): number | null {
  for (const line of view.contentDOM.querySelectorAll('.cm-line')) {
    const { top, bottom } = line.getBoundingClientRect();
    if (y >= top && y < bottom) return view.posAtDOM(line);
  }
  return null;
}

/** A press on a line number also toggles the breakpoint, which makes the target larger for a finger. */
const numbers = (hooks: EditorHooks) => lineNumbers({ domEventHandlers: { mousedown: (view, block, event) => toggled(hooks, view, block.from, event as MouseEvent) } });

// --- completion

function completions(hooks: EditorHooks) {
  return (context: CompletionContext): CompletionResult | null => {
    const word = context.matchBefore(/[A-Za-z_]\w*/);
    if (!word && !context.explicit) return null;
    const line = context.state.doc.lineAt(context.pos);
    const before = line.text.slice(0, (word?.from ?? context.pos) - line.from);
    if (before.includes('#') || (before.match(/"/g)?.length ?? 0) % 2 === 1) return null;
    const first = before.trim() === '';
    const own = new Set<string>();
    for (const found of context.state.doc.toString().matchAll(/\b(?:let|func|for)\s+([A-Za-z_]\w*)/gi)) own.add(found[1]!);
    const options = [
      ...hooks.language.words
        .filter((each) => !each.in_tests && first === ['statement', 'branch', 'closer'].includes(each.role))
        .map((each) => ({ label: each.name, type: 'keyword', detail: each.form === each.name ? '' : each.form, info: each.meaning || undefined, boost: first ? 10 : -1 })),
      ...(first ? [] : hooks.names().map((each) => ({ label: each.name, type: each.kind, detail: each.kind, info: each.text || undefined, boost: 5 }))),
      ...[...own].map((label) => ({ label, type: 'variable', detail: '', boost: 6 })),
      ...hooks.language.functions
        .filter((each) => !each.in_tests)
        .map((each) => ({ label: each.name, type: 'function', detail: each.signature.slice(each.name.length), info: each.meaning || undefined, apply: `${each.name}(`, boost: -2 })),
    ];
    return { from: word?.from ?? context.pos, options, validFor: /^\w*$/ };
  };
}

// --- the editor

const look = EditorView.theme({
  '&': { height: '100%', fontSize: '15px', backgroundColor: 'var(--surface)', color: 'var(--text)' },
  '.cm-scroller': { fontFamily: 'var(--mono)', lineHeight: '1.6', overflow: 'auto' },
  '.cm-content': { padding: '8px 0 40vh', caretColor: 'var(--text)' },
  '.cm-cursor': { borderLeftColor: 'var(--text)', borderLeftWidth: '2px' },
  '&.cm-focused': { outline: 'none' },
  '.cm-selectionBackground, &.cm-focused > .cm-scroller > .cm-selectionLayer .cm-selectionBackground': { backgroundColor: 'var(--accent-soft)' },
  '.cm-gutters': { backgroundColor: 'var(--raised)', color: 'var(--muted)', borderRight: '1px solid var(--line)' },
  '.cm-lineNumbers .cm-gutterElement': { padding: '0 8px 0 4px', minWidth: '34px', cursor: 'pointer' },
  '.cm-marks': { width: '26px', cursor: 'pointer' },
  '.cm-marks .cm-gutterElement': { display: 'grid', placeItems: 'center' },
  '.cm-marks .cm-gutterElement:empty:hover::before': { content: '""', width: '12px', height: '12px', borderRadius: '50%', border: '2px solid var(--bad)' },
  '.cm-activeLine': { backgroundColor: 'color-mix(in srgb, var(--accent-soft) 35%, transparent)' },
  '.cm-activeLineGutter': { backgroundColor: 'transparent', color: 'var(--text)' },
  '.cm-live, .cm-live.cm-activeLine': { backgroundColor: 'var(--code-live)' },
  '.cm-tooltip': { backgroundColor: 'var(--surface)', color: 'var(--text)', border: '1px solid var(--line-strong)', borderRadius: '8px', boxShadow: 'var(--shadow)', maxWidth: 'min(520px, 90vw)' },
  '.cm-tooltip-autocomplete > ul': { fontFamily: 'var(--mono)', maxHeight: '14em' },
  '.cm-tooltip-autocomplete > ul > li': { padding: '6px 10px !important' },
  '.cm-tooltip-autocomplete > ul > li[aria-selected]': { backgroundColor: 'var(--accent) !important', color: 'var(--on-accent) !important' },
  '.cm-completionDetail': { color: 'inherit', opacity: '0.75', fontStyle: 'normal', marginLeft: '1em' },
  '.cm-completionInfo': { padding: '6px 10px', fontFamily: 'var(--font)' },
  '.cm-diagnostic': { padding: '6px 10px', borderLeft: '4px solid var(--bad-fill)', fontFamily: 'var(--font)' },
  '.cm-diagnostic-warning': { borderLeftColor: 'var(--warn-fill)' },
  '.cm-panels': { backgroundColor: 'var(--raised)', color: 'var(--text)', borderColor: 'var(--line)' },
  '.cm-panel input, .cm-panel button': { minHeight: '36px', fontSize: '14px' },
  '.cm-searchMatch': { backgroundColor: 'var(--warn-soft)', outline: '1px solid var(--warn)' },
  '.cm-matchingBracket': { outline: '1px solid var(--accent)' },
});

/** Marks a change from outside the editor, which is not an edit of the user. */
const fromOutside = StateEffect.define<null>();

/** A finding in the lines of a tooltip. */
function lintWords(each: Problem): string {
  const { text, detail, advice } = findingWords(each);
  return [text, detail, advice].filter(Boolean).join('\n');
}

export class ProgramEditor {
  readonly view: EditorView;
  private readonly readOnly = new Compartment();

  constructor(parent: HTMLElement, text: string, private readonly hooks: EditorHooks) {
    this.view = new EditorView({ parent, state: this.state(text) });
    this.view.scrollDOM.tabIndex = 0;
  }

  private state(text: string): EditorState {
    const hooks = this.hooks;
    const extensions: Extension[] = [
      live, breaks, markGutter(hooks), numbers(hooks), lintGutter(), history(), drawSelection(), indentOnInput(), bracketMatching(),
      closeBrackets(), highlightActiveLine(), highlightSelectionMatches(), search({ top: true }), indentUnit.of('  '),
      mode(hooks.language), indents, colours, look, EditorState.phrases.of(hooks.phrases), this.readOnly.of([]),
      autocompletion({ override: [completions(hooks)], icons: false }),
      EditorView.contentAttributes.of({ 'aria-label': hooks.label, autocapitalize: 'off', autocorrect: 'off', spellcheck: 'false' }),
      keymap.of([
        { key: 'F9', run: (view) => (hooks.onBreakpoint(view.state.doc.lineAt(view.state.selection.main.head).number), true) },
        { key: 'Mod-/', run: toggleComment },
        ...closeBracketsKeymap, ...defaultKeymap, ...searchKeymap, ...historyKeymap, ...completionKeymap, indentWithTab,
      ]),
      EditorView.updateListener.of((update) => {
        const outside = update.transactions.some((each) => each.effects.some((effect) => effect.is(fromOutside)));
        if (update.docChanged && !outside) hooks.onChange(update.state.doc.toString(), linesMoved(update.startState.doc, update.changes, update.state.doc));
        if (update.selectionSet || update.docChanged)
          hooks.onLine(update.state.doc.lineAt(update.state.selection.main.head).number);
      }),
    ];
    return EditorState.create({ doc: text, extensions });
  }

  /** Opens another file with an empty undo history. */
  open(text: string): void {
    this.view.setState(this.state(text));
  }

  /** Replaces the text of the same file. The user can undo it. */
  take(text: string): void {
    const now = this.view.state.doc.toString();
    if (now === text) return;
    let from = 0;
    while (from < now.length && from < text.length && now[from] === text[from]) ++from;
    let end = 0;
    while (end < now.length - from && end < text.length - from && now[now.length - 1 - end] === text[text.length - 1 - end]) ++end;
    this.view.dispatch({
      changes: { from, to: now.length - end, insert: text.slice(from, text.length - end) },
      effects: fromOutside.of(null),
      annotations: Transaction.userEvent.of('input.outside'),
    });
  }

  /** Call it again when the language or its tables change. */
  showProblems(problems: Problem[]): void {
    const doc = this.view.state.doc;
    const found = problems
      .filter((each) => each.line >= 1 && each.line <= doc.lines)
      .map((each): Diagnostic => {
        const line = doc.line(each.line);
        const from = Math.min(line.to, line.from + Math.max(0, each.column - 1));
        const word = /^[\w"`.]+/.exec(line.text.slice(from - line.from))?.[0].length ?? 0;
        const to = each.column > 0 && word > 0 ? from + word : line.to;
        return { from: Math.min(from, to), to, severity: each.severity, message: lintWords(each) };
      });
    this.view.dispatch(setDiagnostics(this.view.state, found));
  }

  showLive(lines: number[]): void {
    this.view.dispatch({ effects: setLive.of(lines) });
    const line = lines[0];
    if (!line || line > this.view.state.doc.lines) return;
    const at = this.view.state.doc.line(line).from;
    const block = this.view.lineBlockAt(at);
    const box = this.view.scrollDOM;
    if (!this.view.hasFocus && (block.top < box.scrollTop || block.bottom > box.scrollTop + box.clientHeight))
      this.view.dispatch({ effects: EditorView.scrollIntoView(at, { y: 'center' }) });
  }

  showBreakpoints(lines: number[]): void {
    const now = this.view.state.field(breaks);
    if (now.size === lines.length && lines.every((line) => now.has(line))) return;
    this.view.dispatch({ effects: setBreaks.of(lines) });
  }

  goTo(line: number): void {
    const at = this.view.state.doc.line(Math.max(1, Math.min(line, this.view.state.doc.lines)));
    this.view.dispatch({ selection: { anchor: at.from }, effects: EditorView.scrollIntoView(at.from, { y: 'center' }) });
    this.view.focus();
  }

  destroy(): void {
    this.view.destroy();
  }
}
