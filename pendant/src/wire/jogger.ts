/**
 * Manual motion over the wire: begin, a beat every kBeatMs while the key is held, end. Any error ends it, and
 * only a new press starts it again. At most one motion at a time.
 */
import type { Json } from './connection';
import type { JogBegun } from './requests';

export const kBeatMs = 40;

export interface JogWire {
  request: (name: 'jog.begin' | 'jog.goto', args: Json) => Promise<Pick<JogBegun, 'jog'>>;
  tell: (name: 'jog.beat' | 'jog.end', args: Json) => boolean;
}

export interface JogMotion {
  /** The request that starts the motion, and its arguments. */
  request: 'jog.begin' | 'jog.goto';
  args: Json;
}

export class Jogger {
  private press = 0;
  private jog: number | null = null;
  private timer: ReturnType<typeof setInterval> | undefined;
  private change: Json = {};

  constructor(
    private readonly wire: JogWire,
    /**
     * Called when the key begins to be held, and when the motion has ended (with the error, if there was
     * one).
     */
    private readonly onChange: (held: boolean, error?: unknown) => void,
  ) {}

  get held(): boolean {
    return this.press > 0 && this.active;
  }
  private active = false;

  async begin(motion: JogMotion): Promise<void> {
    this.end();
    const press = ++this.press;
    this.active = true;
    this.change = {};
    this.onChange(true);
    try {
      const answer = await this.wire.request(motion.request, motion.args);
      if (press !== this.press || !this.active) {
        // The key was released before the answer came.
        this.wire.tell('jog.end', { jog: answer.jog });
        return;
      }
      this.jog = answer.jog;
      this.beat();
      this.timer = setInterval(() => this.beat(), kBeatMs);
    } catch (error) {
      if (press === this.press) this.over(error);
    }
  }

  /** Changes speed or direction with the next beat. */
  steer(change: Json): void {
    this.change = { ...this.change, ...change };
  }

  end(): void {
    if (!this.active) return;
    if (this.jog !== null) this.wire.tell('jog.end', { jog: this.jog });
    this.over();
  }

  /** The cell reports the end of a motion. Returns true if it is the present one. */
  ended(jog: number): boolean {
    if (!this.active || this.jog !== jog) return false;
    this.over();
    return true;
  }

  private beat(): void {
    const heard = this.wire.tell('jog.beat', { jog: this.jog!, ...this.change });
    this.change = {};
    if (!heard) this.over();
  }

  private over(error?: unknown): void {
    clearInterval(this.timer);
    this.timer = undefined;
    this.jog = null;
    this.active = false;
    this.onChange(false, error);
  }
}
