/** Formats numbers for operators. The wire uses SI units; pages show mm, degrees and s. */
import { number } from '../i18n';
import { settings } from '../state/settings';

export const kMm = 1000;
export const kDeg = 180 / Math.PI;

export const mm = (metres: number, digits = 1) => number(metres * kMm, digits);
export function angle(rad: number, digits = 1): string {
  return settings.degrees.value ? number(rad * kDeg, digits) : number(rad, digits + 2);
}
export const angleUnit = () => (settings.degrees.value ? '°' : 'rad');

/** A joint's value with its unit, as chosen in the settings. */
export function jointText(value: number, unit: string, digits = 1): string {
  return unit === 'm' ? `${mm(value, digits)} mm` : `${angle(value, digits)} ${angleUnit()}`;
}

/** A readable name: “shoulder pan” for `shoulder_pan_joint`. */
export function jointTitle(name: string): string {
  return name.replace(/[_-]?joint[_-]?/gi, ' ').replace(/[_-]/g, ' ').trim() || name;
}

/** The parts of a name between which a line may break: Activate|Gripper, part_|held. */
export const nameParts = (name: string): string[] => name.split(/(?<=[\p{Ll}\d])(?=\p{Lu})|(?<=_)/u);

/** Words of a list within a sentence: “Take origin”. */
export const withinSentence = (words: string): string => words.charAt(0).toLowerCase() + words.slice(1);

/** Seconds as 12.3 s, as 4:05 from a minute on, or as 1:02:03. */
export function duration(seconds: number): string {
  if (!Number.isFinite(seconds)) return '–';
  if (seconds < 60) return `${number(seconds, 1)} s`;
  const whole = Math.floor(seconds);
  const pad = (n: number) => String(n).padStart(2, '0');
  const h = Math.floor(whole / 3600);
  const m = Math.floor((whole % 3600) / 60);
  return h > 0 ? `${h}:${pad(m)}:${pad(whole % 60)}` : `${m}:${pad(whole % 60)}`;
}

/** Cell time (s since it began) as 00:01:23.4, in the number format of the language. */
export function clockTime(seconds: number): string {
  const pad = (n: number) => String(Math.floor(n)).padStart(2, '0');
  const rest = number(seconds % 60, 1).padStart(4, '0');
  return `${pad(seconds / 3600)}:${pad((seconds % 3600) / 60)}:${rest}`;
}

/**
 * The unit of display for a unit of the wire, and the factor: mm for m; degrees for rad if degrees are
 * chosen.
 */
export function shownIn(unit: string): { unit: string; factor: number } {
  const found = /^(rad|m)(\/s2?)?$/.exec(unit);
  if (!found || (found[1] === 'rad' && !settings.degrees.value)) return { unit, factor: 1 };
  const rate = (found[2] ?? '').replace('2', '²');
  return found[1] === 'm' ? { unit: `mm${rate}`, factor: kMm } : { unit: `°${rate}`, factor: kDeg };
}

/** A program value with fewer digits: 0.68 for 0.6799999999999999. Texts do not change. */
export function shortened(value: string): string {
  return value.replace(/"(?:[^"\\]|\\.)*"|(?<![\w.])-?\d+\.\d{5,}(?:e[-+]?\d+)?/g, (found) => (found.startsWith('"') ? found : String(Number(Number(found).toPrecision(6)))));
}

/** The number of decimals that distinguishes steps of this size. */
export function decimalsOf(step: number): number {
  for (let digits = 0; digits < 9; ++digits) {
    const scaled = step * 10 ** digits;
    if (Math.abs(scaled - Math.round(scaled)) < 1e-6 * Math.max(1, scaled)) return digits;
  }
  return 9;
}

/** A place in a file of the cell, without the cell's folder. Places elsewhere do not change. */
export const placeIn = (folder: string, where: string): string => (folder !== '' && where.startsWith(`${folder}/`) ? where.slice(folder.length + 1) : where);
