/**
 * Saves edits on the server within a second, and in this browser until the server has them. What this page may not send, or
 * what the server refuses, stays in this browser.
 */

/** `waiting`: sent again by itself. `here`: only in this browser, until something changes. */
export type DraftState = 'none' | 'kept' | 'keeping' | 'waiting' | 'here';

export interface Draft {
  name: string;
  text: string;
  /** Hash of the file from which the draft was started. */
  base: string;
}

export interface DraftStore {
  get(name: string): Draft | null;
  set(draft: Draft): void;
  remove(name: string): void;
}

export interface DraftOptions {
  send: (draft: Draft) => Promise<unknown>;
  /** False while the server would refuse every draft of this page. Call `retry` when it becomes true. */
  may: () => boolean;
  /** True if the same draft would be refused again. */
  isRefusal: (error: unknown) => boolean;
  onState: (state: DraftState) => void;
  store: DraftStore;
  /** `wait`: ms after the last change; `longest`: ms after the first unsaved change at most. */
  wait?: number;
  longest?: number;
  again?: number;
}

export class DraftKeeper {
  private newest: Draft | null = null;
  private first = 0;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private sending = false;

  constructor(private readonly options: DraftOptions) {}

  note(draft: Draft): void {
    if (this.newest && this.newest.name !== draft.name) this.flush();
    this.options.store.set(draft);
    if (!this.newest) this.first = Date.now();
    this.newest = draft;
    this.options.onState('keeping');
    const left = this.first + (this.options.longest ?? 700) - Date.now();
    this.schedule(Math.max(0, Math.min(this.options.wait ?? 300, left)));
  }

  /** Sends unsaved changes now. */
  flush(): void {
    clearTimeout(this.timer);
    void this.push();
  }

  /** Sends what stayed in this browser, if something did. */
  retry(): void {
    if (this.newest) this.flush();
  }

  /** Discards the draft of this file. */
  forget(name: string): void {
    if (this.newest?.name === name) {
      this.newest = null;
      clearTimeout(this.timer);
    }
    this.options.store.remove(name);
    this.options.onState('none');
  }

  private schedule(ms: number): void {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => void this.push(), ms);
  }

  private async push(): Promise<void> {
    const draft = this.newest;
    if (!draft) return;
    if (this.sending) return this.schedule(50);
    if (!this.options.may()) return this.options.onState('here');
    this.sending = true;
    try {
      await this.options.send(draft);
      if (this.newest === draft) {
        this.newest = null;
        this.options.store.remove(draft.name);
        this.options.onState('kept');
      }
    } catch (error) {
      if (this.newest === draft && this.options.isRefusal(error)) {
        this.options.onState('here');
      } else if (this.newest) {
        this.options.onState('waiting');
        this.schedule(this.options.again ?? 1000);
      }
    } finally {
      this.sending = false;
    }
  }
}

const kPrefix = 'polyarm.draft.';
/** The drafts in this browser's storage. */
export const localDrafts: DraftStore = {
  get(name) {
    try {
      return JSON.parse(localStorage.getItem(kPrefix + name) ?? 'null') as Draft | null;
    } catch {
      return null;
    }
  },
  set(draft) {
    try {
      localStorage.setItem(kPrefix + draft.name, JSON.stringify(draft));
    } catch {
      // The storage of a private window may be disabled; the copy on the server is enough.
    }
  },
  remove(name) {
    try {
      localStorage.removeItem(kPrefix + name);
    } catch {
      // The same.
    }
  },
};
