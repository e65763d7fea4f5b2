/**
 * Buttons and fields of all pages. Labels are always available as text for screen readers; targets are at
 * least 44 px.
 */
import type { ComponentChildren } from 'preact';
import { useEffect, useId, useRef, useState } from 'preact/hooks';
import { t } from '../i18n';
import { Icon, type IconName } from './Icon';

export type Tone = 'plain' | 'primary' | 'good' | 'warn' | 'danger' | 'quiet';

interface ButtonProps {
  label: string;
  icon?: IconName;
  /** Shows only the icon. The label is still read out, also where a narrow page hides it. */
  bare?: boolean;
  tone?: Tone;
  big?: boolean;
  pressed?: boolean;
  disabled?: boolean;
  /** Why it is disabled, or what it does. Shown as a tooltip and read out. */
  title?: string;
  badge?: number;
  class?: string;
  onClick: () => void;
}

export function Button(props: ButtonProps) {
  const { label, icon, bare, tone = 'plain', big, pressed, disabled, title, badge } = props;
  return (
    <button
      type="button"
      class={`button ${tone} ${big ? 'big' : ''} ${bare ? 'bare' : ''} ${props.class ?? ''}`}
      aria-label={icon ? label : undefined}
      aria-pressed={pressed === undefined ? undefined : pressed}
      title={title ?? (bare ? label : undefined)}
      disabled={disabled}
      onClick={props.onClick}
    >
      {icon && <Icon name={icon} size={big ? 28 : 22} />}
      {!bare && <span>{label}</span>}
      {badge ? <span class="badge">{badge}</span> : null}
    </button>
  );
}

interface SegmentedProps<T extends string> {
  label: string;
  value: T;
  options: { id: T; name: string; icon?: IconName; title?: string }[];
  disabled?: boolean;
  onChange: (value: T) => void;
}

/** A choice of a few options, side by side. */
export function Segmented<T extends string>({ label, value, options, disabled, onChange }: SegmentedProps<T>) {
  const name = useId();
  const row = useRef<HTMLDivElement>(null);
  // Where the row scrolls, the chosen option is in view.
  useEffect(() => {
    const chosen = row.current?.querySelector<HTMLElement>('.chosen');
    const box = [row.current, row.current?.parentElement].find((each) => each && each.scrollWidth > each.clientWidth);
    if (!box || !chosen) return;
    const at = chosen.getBoundingClientRect().left - box.getBoundingClientRect().left;
    box.scrollLeft += at - (box.clientWidth - chosen.offsetWidth) / 2;
  }, [value]);
  return (
    <div ref={row} class="segmented" role="radiogroup" aria-label={label}>
      {options.map((option) => (
        <label key={option.id} class={option.id === value ? 'chosen' : ''} title={option.title}>
          <input
            type="radio"
            name={name}
            checked={option.id === value}
            disabled={disabled}
            onChange={() => onChange(option.id)}
          />
          {option.icon && <Icon name={option.icon} size={20} />}
          <span>{option.name}</span>
        </label>
      ))}
    </div>
  );
}

interface SliderProps {
  label: string;
  value: number;
  min: number;
  max: number;
  step?: number;
  unit?: string;
  disabled?: boolean;
  /** Called while the slider is dragged. */
  onInput?: (value: number) => void;
  /** Called when the slider is released. */
  onChange?: (value: number) => void;
  shown?: string;
  hideLabel?: boolean;
}

export function Slider(props: SliderProps) {
  const { label, value, min, max, step = 1, unit = '', shown } = props;
  const [dragged, setDragged] = useState<number | null>(null);
  const id = useId();
  const now = dragged ?? value;
  const share = (100 * (now - min)) / (max - min || 1);
  const text = shown && dragged === null ? shown : `${now} ${unit}`;
  return (
    <div class={`slider ${props.hideLabel ? 'tight' : ''}`}>
      <label for={id}>{label}</label>
      <input
        id={id}
        type="range"
        min={min}
        max={max}
        step={step}
        value={now}
        disabled={props.disabled}
        aria-valuetext={text}
        style={{ '--share': `${share}%` }}
        onInput={(e) => {
          const next = Number(e.currentTarget.value);
          setDragged(next);
          props.onInput?.(next);
        }}
        onChange={(e) => {
          setDragged(null);
          props.onChange?.(Number(e.currentTarget.value));
        }}
      />
      <output for={id}>{text}</output>
    </div>
  );
}

export function Toggle(props: { label: string; value: boolean; disabled?: boolean; onChange: (on: boolean) => void }) {
  return (
    <label class="toggle">
      <input
        type="checkbox"
        role="switch"
        checked={props.value}
        disabled={props.disabled}
        onChange={(e) => props.onChange(e.currentTarget.checked)}
      />
      <span class="track" aria-hidden="true" />
      <span>{props.label}</span>
    </label>
  );
}

export function Search(props: { label: string; value: string; class?: string; onInput: (words: string) => void }) {
  return (
    <div class={`search ${props.class ?? ''}`}>
      <Icon name="search" size={20} />
      <input type="search" aria-label={props.label} placeholder={props.label} value={props.value} onInput={(e) => props.onInput(e.currentTarget.value)} />
    </div>
  );
}

interface FieldProps {
  /** Of a log-in, so that the browser can fill it in. */
  login?: { name: string; type: 'text' | 'password'; autocomplete: string };
  label: string;
  value: string;
  unit?: string;
  placeholder?: string;
  problem?: string;
  disabled?: boolean;
  numeric?: boolean;
  onInput?: (value: string) => void;
  onChange?: (value: string) => void;
  onEnter?: () => void;
}

export function Field(props: FieldProps) {
  const id = useId();
  return (
    <div class={`field ${props.problem ? 'wrong' : ''}`}>
      <label for={id}>{props.label}</label>
      <div class="box">
        <input
          id={id}
          type={(props.login?.type ?? 'text') as 'text'}
          name={props.login?.name}
          value={props.value}
          placeholder={props.placeholder}
          disabled={props.disabled}
          inputMode={props.numeric ? 'decimal' : undefined}
          autocomplete={props.login?.autocomplete ?? 'off'}
          spellcheck={false}
          aria-invalid={props.problem ? true : undefined}
          aria-describedby={props.problem ? `${id}-problem` : undefined}
          onInput={(e) => props.onInput?.(e.currentTarget.value)}
          onChange={(e) => props.onChange?.(e.currentTarget.value)}
          onKeyDown={(e) => {
            if (e.key === 'Enter') props.onEnter?.();
          }}
        />
        {props.unit && <span class="unit">{props.unit}</span>}
      </div>
      {props.problem && (
        <p class="problem" id={`${id}-problem`}>
          {props.problem}
        </p>
      )}
    </div>
  );
}

export function Select(props: {
  label: string;
  value: string;
  options: { id: string; name: string }[];
  disabled?: boolean;
  onChange: (value: string) => void;
}) {
  const id = useId();
  return (
    <div class="field">
      <label for={id}>{props.label}</label>
      <div class="box">
        <select id={id} value={props.value} disabled={props.disabled} onChange={(e) => props.onChange(e.currentTarget.value)}>
          {props.options.map((option) => (
            <option key={option.id} value={option.id}>
              {option.name}
            </option>
          ))}
        </select>
        <Icon name="down" size={18} />
      </div>
    </div>
  );
}

/** A titled card on a page. */
export function Card(props: { title?: string; actions?: ComponentChildren; class?: string; children: ComponentChildren }) {
  const id = useId();
  return (
    <section class={`card ${props.class ?? ''}`} aria-labelledby={props.title ? id : undefined}>
      {(props.title || props.actions) && (
        <header>
          {props.title && <h2 id={id}>{props.title}</h2>}
          {props.actions && <div class="actions">{props.actions}</div>}
        </header>
      )}
      {props.children}
    </section>
  );
}

/** Shown where a page has no content. */
export function Empty({ icon, text, children }: { icon: IconName; text: string; children?: ComponentChildren }) {
  return (
    <div class="empty">
      <Icon name={icon} size={40} />
      <p>{text}</p>
      {children}
    </div>
  );
}

export function Loading() {
  return (
    <div class="empty" role="status">
      <span class="spinner" aria-hidden="true" />
      <p>{t('page.loading')}</p>
    </div>
  );
}
