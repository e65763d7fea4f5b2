/**
 * Sends a target that the robot follows: `target` every 50 ms, each valid for slightly longer. If no more
 * targets arrive, for any reason, the robot stops.
 */
import type { Json } from './connection';

export const kEveryMs = 50;
/** Validity of a target, s: longer than the usual delay of the next one, shorter than a person notices. */
export const kGoodForS = 0.15;
const kMostUnderway = 3;

export class Follower {
  private timer: ReturnType<typeof setInterval> | undefined;
  private session: number | null = null;
  private underway = 0;
  private round = 0;
  private target: Json | null = null;

  constructor(
    private readonly ask: (request: 'target', args: Json, timeout: number) => Promise<{ session?: number }>,
    private readonly onEnd: (error?: unknown) => void,
  ) {}

  get held(): boolean {
    return this.timer !== undefined;
  }

  begin(target: Json | null): void {
    this.end();
    ++this.round;
    this.session = null;
    this.target = target;
    this.timer = setInterval(() => this.send(), kEveryMs);
    this.send();
  }

  /** Changes the target. */
  set(target: Json): void {
    this.target = target;
  }

  end(error?: unknown): void {
    if (!this.held) return;
    clearInterval(this.timer);
    this.timer = undefined;
    this.target = null;
    this.onEnd(error);
  }

  private send(): void {
    if (!this.target || this.underway >= kMostUnderway || (this.session === null && this.underway > 0)) return;
    const round = this.round;
    const session = this.session === null ? {} : { session: this.session };
    ++this.underway;
    this.ask('target', { ...this.target, hold: kGoodForS, ...session }, 2_000)
      .then(
        (answer) => {
          if (round === this.round && this.session === null) this.session = answer.session ?? null;
        },
        (error: unknown) => {
          if (round === this.round) this.end(error);
        },
      )
      .finally(() => --this.underway);
  }
}
