/** The open program file: its text, the file and draft behind it, the checker's problems, earlier texts. */
import type { Args } from '../../state/cell';
import { computed, effect, signal, untracked } from '@preact/signals';
import { t } from '../../i18n';
import type { Facts } from '../../i18n/told';
import { attempt, complain, connected, mayProgram, program, request, status } from '../../state/cell';
import { kept, settings } from '../../state/settings';
import { toast } from '../../state/toasts';
import type { ProgramStatus } from '../../wire/types';
import { RequestError } from '../../wire/connection';
import { BreakpointKeeper, type LineMap } from './breakpoints';
import { DraftKeeper, type DraftState, localDrafts } from './drafts';
import { byFile, sameFile } from './sameFile';
import { type Statement, statementsOf } from './statements';

export { sameFile };

export interface FileInfo {
  name: string;
  kind: string;
  bytes: number;
  modified_s: number;
  hash: string;
  running: boolean;
  draft: boolean;
}
export interface Problem {
  severity: 'error' | 'warning';
  code: string;
  what: string;
  advice: string;
  file: string;
  line: number;
  column: number;
  facts?: Facts;
}
export const files = signal<FileInfo[]>([]);
export const mainFile = signal<string | null>(null);
export const chosenFile = kept<string>('program.file', '');
/** Name of the open file; empty: none. */
export const fileName = signal('');
export const text = signal('');
/** The file as it was last read or written, and its hash ('' if there is no file yet). */
export const savedText = signal('');
export const base = signal('');
export const draftState = signal<DraftState>('none');
/** Author and time of a draft that was found instead of written here. */
export const foundDraft = signal<{ by: string; saved_s: number } | null>(null);
/** The file's new content if another client has changed it. */
export const theirs = signal<{ text: string; hash: string } | null>(null);
export const problems = signal<Problem[]>([]);
/** Problems of files that this one includes. */
export const elsewhere = signal<Problem[]>([]);
/** True if `problems` belongs to the present text. */
export const checked = signal(false);
/** Increases when something other than the editor changes the text. */
export const revision = signal(0);
/** The user's current line; steps and editor share it. */
export const atLine = signal(1);
/** A line to show. The view that shows the text scrolls there and clears it. */
export const wantedLine = signal<number | null>(null);
const undone: string[] = [];
export const canUndo = signal(false);

export const dirty = computed(() => fileName.value !== '' && text.value !== savedText.value);
export const statements = computed<Statement[]>(() => statementsOf(text.value));
export const programFiles = computed(() => files.value.filter((each) => each.kind === 'program' || each.kind === 'plc'));
const isError = (each: Problem) => each.severity === 'error';
/** With those of included files: with one of them the program cannot start. */
export const errors = computed(() => problems.value.filter(isError).length + elsewhere.value.filter(isError).length);
/** True if the file is a program, not data, points or a scene. */
export const isProgram = computed(() => {
  const info = files.value.find((each) => each.name === fileName.value);
  return info ? info.kind === 'program' || info.kind === 'plc' : /\.script$/.test(fileName.value);
});

/** The running program, if it is this file. */
export const running = computed<ProgramStatus | null>(() => {
  const now = status.value?.program;
  if (!now || !sameFile(now.file, fileName.value)) return null;
  return !now.ready && (now.state === 'running' || now.state === 'waiting') ? now : null;
});
/** True if any program is running. */
export const anyRunning = computed(() => {
  const it = status.value?.program;
  return !!it && !it.ready && (it.state === 'running' || it.state === 'waiting');
});

/** Codes of requests that the cell has not judged. */
const kNotAnswered = new Set(['not-connected', 'no-answer', 'no-cell', 'busy', 'overtaken']);
const keeper = new DraftKeeper({
  send: (draft) => request('files.draft', { ...draft, by: settings.clientName.peek() }, 3000),
  // Without a connection the page does not know; the request then fails, and is sent again.
  may: () => mayProgram.peek() || !connected.peek(),
  isRefusal: (error) => error instanceof RequestError && !kNotAnswered.has(error.code),
  onState: (state) => (draftState.value = state),
  store: localDrafts,
});
/** The file whose breakpoints have moved in this browser only. */
let movedHere = '';
effect(() => {
  if (!mayProgram.value) return;
  keeper.retry();
  if (movedHere !== '' && movedHere === fileName.peek()) untracked(() => marks.retell());
  movedHere = '';
});

// --- files

export async function loadFiles(): Promise<void> {
  try {
    const answer = await request('files');
    if (JSON.stringify(answer.files) !== JSON.stringify(files.value)) files.value = answer.files;
    mainFile.value = answer.main;
    const mine = answer.files.find((each) => each.name === fileName.value);
    if (mine && base.value !== '' && mine.hash !== base.value && !theirs.value) await lookAtTheirs();
  } catch (error) {
    complain(error);
  }
}

/** Opens the file that was open last, else the cell's program. */
export async function openSomething(): Promise<void> {
  await loadFiles();
  if (fileName.value !== '') return;
  // A new file that was never saved is only a draft and is in no list.
  if (chosenFile.value !== '' && (await openFile(chosenFile.value, true))) return;
  const known = (name: string | null | undefined) => files.value.find((each) => each.name === name)?.name;
  const next = known(mainFile.value) ?? programFiles.value[0]?.name;
  if (next) await openFile(next);
}

/** Returns true if the file is open. `quiet`: reports no error if the file does not exist. */
export async function openFile(name: string, quiet = false): Promise<boolean> {
  keeper.flush();
  try {
    const answer = await request('files.read', { name });
    const local = localDrafts.get(name);
    const draft = local ?? answer.draft;
    show(name, draft?.text ?? answer.text, answer.text, draft?.base ?? answer.hash);
    if (draft && draft.text === answer.text) {
      base.value = answer.hash;
      dropDraft();
    } else if (draft) {
      foundDraft.value = local ? { by: '', saved_s: Date.now() / 1000 } : { by: answer.draft!.by, saved_s: answer.draft!.saved_s };
      draftState.value = 'kept';
      if (local) keeper.note(local);
      if (draft.base !== answer.hash) theirs.value = { text: answer.text, hash: answer.hash };
    }
    chosenFile.value = name;
    return true;
  } catch (error) {
    if (!quiet) complain(error);
    return false;
  }
}

function show(name: string, now: string, saved: string, hash: string): void {
  const same = name === fileName.value;
  fileName.value = name;
  text.value = now;
  if (same) marks.edited(now);
  else marks.open(name, now, untracked(toldBreakpoints));
  savedText.value = saved;
  base.value = hash;
  foundDraft.value = null;
  theirs.value = null;
  draftState.value = 'none';
  problems.value = [];
  elsewhere.value = [];
  checked.value = false;
  undone.length = 0;
  canUndo.value = false;
  atLine.value = 1;
  revision.value++;
}

/** Opens a new file, which is a draft until it is saved. */
export function newFile(name: string, first: string): void {
  keeper.flush();
  show(name, first, '', '');
  chosenFile.value = name;
  keeper.note({ name, text: first, base: '' });
}

export async function closeDeleted(name: string): Promise<void> {
  keeper.forget(name);
  if (fileName.value === name) fileName.value = '';
  await loadFiles();
  await openSomething();
}

// --- changes

/**
 * Takes a new text from the editor or the steps. `map`: the new positions of the lines, if they are known
 * exactly.
 */
export function edit(next: string, map?: LineMap): void {
  if (next === text.value) return;
  text.value = next;
  marks.edited(next, map);
  checked.value = false;
  if (next === savedText.value && !theirs.value) dropDraft();
  else keeper.note({ name: fileName.value, text: next, base: base.value });
}

/** Changes the text from outside the editor. `undo` can undo it. */
export function change(next: string, line?: number): void {
  if (next === text.value) return;
  undone.push(text.value);
  if (undone.length > 200) undone.shift();
  canUndo.value = true;
  edit(next);
  revision.value++;
  if (line) atLine.value = line;
}
export function undo(): void {
  const before = undone.pop();
  canUndo.value = undone.length > 0;
  if (before === undefined) return;
  edit(before);
  revision.value++;
}

function dropDraft(): void {
  keeper.forget(fileName.value);
  foundDraft.value = null;
  if (mayProgram.peek()) void request('files.draft', { name: fileName.value }).catch(() => undefined);
}

/** Discards the draft and returns to the saved file. */
export function discardDraft(): void {
  if (theirs.value) {
    savedText.value = theirs.value.text;
    base.value = theirs.value.hash;
    theirs.value = null;
  }
  undone.push(text.value);
  canUndo.value = true;
  text.value = savedText.value;
  marks.edited(savedText.value);
  revision.value++;
  checked.value = false;
  dropDraft();
}

async function lookAtTheirs(): Promise<void> {
  const answer = await request('files.read', { name: fileName.value });
  if (answer.hash === base.value) return;
  if (answer.text === text.value || text.value === savedText.value) {
    // There are no unsaved changes: shows the new content.
    const line = atLine.value;
    show(fileName.value, answer.text, answer.text, answer.hash);
    atLine.value = line;
    toast({ kind: 'info', text: t('program.reloaded', { name: fileName.value }) });
  } else theirs.value = { text: answer.text, hash: answer.hash };
}

/** Saves the file. Returns true if the file contains the text. */
export async function save(): Promise<boolean> {
  const name = fileName.value;
  const now = text.value;
  try {
    const answer = await request('files.write', { name, text: now, base: base.value });
    written(now, answer.hash);
    return true;
  } catch (error) {
    if (!(error instanceof RequestError) || error.code !== 'changed-meanwhile') {
      complain(error);
      return false;
    }
    await lookAtTheirs().catch(complain);
    return false;
  }
}

function written(now: string, hash: string): void {
  savedText.value = now;
  base.value = hash;
  theirs.value = null;
  foundDraft.value = null;
  if (text.value === now) keeper.forget(fileName.value);
  draftState.value = text.value === now ? 'none' : draftState.value;
  toast({ kind: 'ok', text: t('program.saved', { name: fileName.value }) });
  void loadFiles();
}

/** Writes the merged text over the file that another client has changed. */
export async function saveMerged(next: string): Promise<void> {
  const other = theirs.value;
  if (!other) return;
  change(next);
  base.value = other.hash;
  savedText.value = other.text;
  theirs.value = null;
  if (next !== other.text) await save();
  else dropDraft();
}

export async function saveAs(name: string): Promise<boolean> {
  try {
    const answer = await request('files.write', { name, text: text.value, base: '' });
    const now = text.value;
    show(name, now, now, answer.hash);
    chosenFile.value = name;
    toast({ kind: 'ok', text: t('program.saved', { name }) });
    await loadFiles();
    return true;
  } catch (error) {
    complain(error);
    return false;
  }
}

// --- the checker

async function check(name: string, now: string): Promise<void> {
  try {
    const answer = await request('program.check', { name, text: now });
    if (text.peek() !== now || fileName.peek() !== name) return;
    const found = byFile(answer.problems, name);
    problems.value = found.own;
    elsewhere.value = found.elsewhere;
    checked.value = true;
  } catch {
    // Not connected, or no cell: the next change checks again.
  }
}

const kCheckMs = 250;
const kLookMs = 4000;
/**
 * Call it while the page is open. Checks the text, and regularly checks whether the file has changed. Returns
 * a function that ends it.
 */
export function follow(): () => void {
  let timer: ReturnType<typeof setTimeout> | undefined;
  const checking = effect(() => {
    const name = fileName.value;
    const now = text.value;
    if (!connected.value || name === '' || !isProgram.value) return;
    clearTimeout(timer);
    timer = setTimeout(() => void check(name, now), kCheckMs);
  });
  const opening = effect(() => {
    if (connected.value) void openSomething();
  });
  const looking = setInterval(() => {
    if (connected.peek() && fileName.peek() !== '') void loadFiles();
  }, kLookMs);
  const leave = () => keeper.flush();
  addEventListener('pagehide', leave);
  return () => {
    keeper.flush();
    clearTimeout(timer);
    clearInterval(looking);
    checking();
    opening();
    removeEventListener('pagehide', leave);
  };
}

// --- running the program

/** The hash of the text that the user sees. The cell refuses to start another text. */
export const shownHash = (): { hash?: string } => (base.value ? { hash: base.value } : {});

/** Saves unsaved changes and starts the program. */
export async function start(): Promise<void> {
  if (dirty.value && !(await save())) return;
  await attempt('program.from', { program: fileName.value, confirmed: true, ...shownHash() });
}

/** True if the task has not ended. */
export const goesOn = (task: { state: string }) => task.state === 'running' || task.state === 'waiting';

/** The lines of this file at which tasks are, in the present text. */
export const liveLines = computed<number[]>(() => {
  const all = (program.value?.tasks as { where: { file: string; line: number }; source: string; state: string; paused: boolean }[] | undefined) ?? [];
  if (!anyRunning.value) return [];
  // A paused task comes first, because the view scrolls to the first line.
  const tasks = all.filter(goesOn).sort((a, b) => Number(b.paused) - Number(a.paused));
  const lines = text.value.split('\n');
  const out = new Set<number>();
  for (const task of tasks) {
    if (!sameFile(task.where?.file ?? '', fileName.value)) continue;
    const line = findLine(lines, task.where.line, task.source ?? '');
    if (line) out.add(line);
  }
  return [...out];
});

/**
 * The line that contains `source`, nearest to `line`. The text may have changed since the program was
 * started.
 */
export function findLine(lines: string[], line: number, source: string): number | null {
  const wanted = source.trim();
  if (wanted === '') return line <= lines.length ? line : null;
  const fits = (at: number) => {
    const here = lines[at - 1]?.trim() ?? '';
    return here !== '' && (here.startsWith(wanted) || wanted.startsWith(here));
  };
  for (let off = 0; off < lines.length; ++off) {
    if (fits(line - off)) return line - off;
    if (fits(line + off)) return line + off;
  }
  return null;
}

// --- breakpoints

interface Place {
  file: string;
  line: number;
}
const ofThisFile = (all: Place[]) => all.filter((each) => sameFile(each.file, fileName.peek())).map((each) => each.line);
const toldBreakpoints = () => (program.value ? ofThisFile((program.value.breakpoints as Place[] | undefined) ?? []) : null);

/** The lines with breakpoints in the present text. */
export const breakpoints = signal<number[]>([]);
const marks = new BreakpointKeeper({
  // The breakpoints of a page that may not edit move in its own text only, until it may.
  tell: async (name, now, lines) => {
    if (mayProgram.peek() || !lines) return askBreakpoints('program.edited', { name, text: now, ...(lines && { lines }) });
    movedHere = name;
    return lines;
  },
  toggle: (name, now, line, on) =>
    askBreakpoints('program.break', { [on ? 'at' : 'off']: [`${name}:${line}`], text: now }).catch((error: unknown) => {
      complain(error);
      throw error;
    }),
  onLines: (lines) => {
    if (String(lines) !== String(breakpoints.peek())) breakpoints.value = lines;
  },
});
async function askBreakpoints<Name extends 'program.edited' | 'program.break'>(what: Name, args: Args<Name>): Promise<number[]> {
  const answer = await request<'program.edited' | 'program.break'>(what, args);
  if (program.peek()) program.value = { ...program.peek(), breakpoints: answer.breakpoints };
  return ofThisFile(answer.breakpoints);
}
effect(() => marks.heard(toldBreakpoints()));
export const toggleBreakpoint = (line: number): Promise<void> => marks.toggle(line);
