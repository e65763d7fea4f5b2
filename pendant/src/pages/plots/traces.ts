/**
 * The curves that can be plotted and those that are; their colours; the history, recorded from the first
 * opening of the page.
 */
import { computed } from '@preact/signals';
import { type Key, t } from '../../i18n';
import { cell, robot, tags } from '../../state/cell';
import { layout, onFrame } from '../../state/live';
import { kept } from '../../state/settings';
import { shownIn } from '../../ui/format';
import { History, type Slice } from './history';

export interface Trace {
  name: string;
  /** The unit of display, and the factor from the wire's unit to it. */
  unit: string;
  factor: number;
}

const kSeconds = 300;
const kRate = 30;
export const kMostTraces = 12;
export const history = new History(kSeconds * kRate);
/** Names of the shown traces; null: the user has not chosen yet. */
export const chosen = kept<string[] | null>('plots.traces', null);

const kTag = 'tag ';
const numberOf = (value: unknown) => (typeof value === 'number' ? value : typeof value === 'boolean' ? Number(value) : NaN);

const tagNames = computed(() =>
  Object.keys(tags.value)
    .filter((name) => Number.isFinite(numberOf(tags.value[name]!.value)))
    .sort(),
);
/** All traces: fields of state frames, and tags that are numbers or booleans. */
export const traces = computed<Trace[]>(() => [
  ...layout.value.fields.map(({ name, unit }) => ({ name, ...shownIn(unit) })),
  ...tagNames.value.map((name) => ({ name: kTag + name, unit: '', factor: 1 })),
]);

/** The chosen traces that exist. By default the first joint, measured and commanded. */
export const shown = computed<Trace[]>(() => {
  const known = new Map(traces.value.map((each) => [each.name, each]));
  const names = chosen.value ?? pairOf(robot.value?.joints[0]?.interface ?? '');
  return names.flatMap((name) => known.get(name) ?? []);
});

/** Measured and commanded position of a joint. */
export const pairOf = (joint: string) => [`${joint}/position`, `${joint}/command_position`];
export const isCommand = (name: string) => /\/command_\w+$/.test(name);
const partner = (name: string) => name.replace(/\/command_(\w+)$/, '/$1');

const kDark = ['#6bb0ff', '#ffb454', '#5fd394', '#ff8a8f', '#d3a6ff', '#5ed8e6', '#f5e06e', '#ff9fd0'];
const kLight = ['#0b5cc4', '#a85100', '#14703f', '#b3121d', '#7a2fb8', '#00707e', '#6b5c00', '#ab1f6e'];

/** A command has the colour of its measured value, and is dashed. */
export function colourOf(name: string, all: Trace[], dark: boolean): string {
  const bases = [...new Set(all.map((each) => partner(each.name)))];
  const colours = dark ? kDark : kLight;
  return colours[bases.indexOf(partner(name)) % colours.length]!;
}

let recording = false;
/** Starts recording, until the page is closed. It continues while another page is shown. */
export function record(): void {
  if (recording) return;
  recording = true;
  onFrame((frame) => {
    history.setNames(traces.peek().map((each) => each.name));
    const now = tags.peek();
    const fields = layout.peek().fields.length;
    history.push(frame.time, (name, place) => (place < fields ? (frame.values[place] ?? NaN) : numberOf(now[name.slice(kTag.length)]?.value)));
  });
}

/** The values between two times, in the units of display. */
export function sliceOf(from: number, to: number, list: Trace[]): Slice {
  const { times, columns } = history.slice(from, to, list.map((each) => each.name));
  return { times, columns: columns.map((column, i) => (list[i]!.factor === 1 ? column : column.map((value) => (value === null ? null : value * list[i]!.factor)))) };
}

/** The value of each trace at that time; null if nothing was measured. */
export function valuesAt(time: number, list: Trace[]): (number | null)[] {
  return history.at(time, list.map((each) => each.name)).map((value, i) => (value === null ? null : value * list[i]!.factor));
}

export const titleOf = (trace: Trace) => (trace.unit ? `${trace.name} [${trace.unit}]` : trace.name);

const kWhat: Record<string, Key> = {
  position: 'plots.measured', velocity: 'plots.speed', effort: 'plots.torque',
  command_position: 'plots.commanded', command_velocity: 'plots.commandedSpeed', command_effort: 'plots.commandedTorque',
};

/**
 * A readable name: “shoulder pan, commanded” for `arm/shoulder_pan_joint/command_position`. Includes the
 * robot if there are several.
 */
export function readable(name: string): string {
  if (name.startsWith(kTag)) return t('plots.tag', { name: name.slice(kTag.length) });
  const parts = name.split('/');
  const last = parts.pop()!;
  const robots = cell.value?.robots.map((each) => each.name) ?? [];
  if (robots.length === 1 && parts[0] === robots[0]) parts.shift();
  const middle = parts.map((each) => (each === 'tcp' ? 'TCP' : each.replace(/_joint$/, '').replaceAll('_', ' ')));
  const what = kWhat[last] ? t(kWhat[last]!) : last.replaceAll('_', ' ');
  if (middle.length === 0) return what;
  return parts[parts.length - 1] === 'tcp' || parts[0] === 'loop' ? [...middle, what].join(' ') : `${middle.join(' ')}, ${what}`;
}
