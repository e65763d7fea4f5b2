/** The override: speed in percent of the plan. On a phone the slider is hidden behind its value. */
import { signal } from '@preact/signals';
import { useEffect, useState } from 'preact/hooks';
import { t } from '../i18n';
import { setOverride } from '../state/actions';
import { mayMove, status } from '../state/cell';
import { Slider } from '../ui/controls';

/** The requested value, until the cell reports it. The next press of an arrow key continues from it. */
const wanted = signal<number | null>(null);
const kTellsWithinMs = 1500;
let forget: ReturnType<typeof setTimeout> | undefined;
let latest = -1;
let underway = false;

/** Sends the newest value as soon as the previous request was answered. */
export function wantOverride(percent: number): void {
  wanted.value = latest = percent;
  clearTimeout(forget);
  forget = setTimeout(() => (wanted.value = null), kTellsWithinMs);
  if (!underway) send();
}
function send(): void {
  underway = true;
  const sent = latest;
  void setOverride(sent).finally(() => {
    underway = false;
    if (latest !== sent) send();
  });
}

export function Override() {
  const now = status.value;
  const [open, setOpen] = useState(false);
  const told = now ? Math.round(now.override) : NaN;
  useEffect(() => {
    if (wanted.peek() === told) wanted.value = null;
  }, [told]);
  const percent = wanted.value ?? told;
  const allowed = now?.allowed ?? 100;
  const shown = Number.isFinite(percent) ? `${percent} %` : '–';
  return (
    <div class={`override ${open ? 'open' : ''}`}>
      <button
        type="button"
        class="override-fold"
        aria-expanded={open}
        onClick={() => setOpen(!open)}
      >
        <small>{t('bar.speed')}</small> <strong>{shown}</strong>
      </button>
      <div class="override-slide">
        <Slider
          label={t('bar.speed')}
          value={Number.isFinite(percent) ? percent : 0}
          shown={shown}
          min={0}
          max={100}
          step={1}
          unit="%"
          disabled={!mayMove.value || Number.isNaN(told)}
          onInput={wantOverride}
          onChange={wantOverride}
        />
        {allowed < 100 && now?.moving && <small>{t(now.profile === 'reduced' ? 'bar.allowedReduced' : 'bar.allowedFirst', { percent: Math.round(allowed) })}</small>}
      </div>
    </div>
  );
}
