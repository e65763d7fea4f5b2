/** Parses and writes the call of comply(). No side effects. */
import { splitTop } from './statements';

export interface Compliance {
  /** Such as "x y rz". */
  axes: string;
  /** By the names of the parameters: force, stiffness, damping, most, reach. */
  values: Record<string, string>;
}
export const kComplianceValues = ['force', 'stiffness', 'damping', 'most', 'reach'] as const;

/** Null if the text is no call of comply() with axes as a text and named values. */
export function parseCompliance(text: string): Compliance | null {
  const inside = /^comply\s*\((.*)\)$/i.exec(text.trim());
  if (!inside) return null;
  const [first = '', ...rest] = splitTop(inside[1]!);
  const axes = /^"([^"{}]*)"$/.exec(first);
  if (!axes) return null;
  const values: Record<string, string> = {};
  for (const part of rest) {
    const named = /^(\w+)\s*=(?!=)\s*(.+)$/.exec(part);
    if (!named || !(kComplianceValues as readonly string[]).includes(named[1]!)) return null;
    values[named[1]!] = named[2]!;
  }
  return { axes: axes[1]!, values };
}

export function writeCompliance({ axes, values }: Compliance): string {
  const given = kComplianceValues.filter((name) => values[name]).map((name) => `${name} = ${values[name]}`);
  return `comply(${[`"${axes}"`, ...given].join(', ')})`;
}
