/**
 * Parses a condition into the forms that the form can show: NAME, not NAME, NAME < VALUE. No side effects.
 */
export type Comparison = 'true' | 'false' | '==' | '!=' | '<' | '<=' | '>' | '>=';

export interface Condition {
  name: string;
  how: Comparison;
  value: string;
}

const kName = '([A-Za-z_]\\w*(?:\\.\\w+)*)';

export function parseCondition(text: string): Condition | null {
  const plain = new RegExp(`^(not\\s+)?${kName}$`, 'i').exec(text.trim());
  if (plain) return { name: plain[2]!, how: plain[1] ? 'false' : 'true', value: '' };
  const compared = new RegExp(`^${kName}\\s*(==|!=|<=|>=|<|>)\\s*(.+)$`).exec(text.trim());
  if (!compared || /\b(and|or)\b/i.test(compared[3]!)) return null;
  return { name: compared[1]!, how: compared[2] as Comparison, value: compared[3]! };
}

export function writeCondition({ name, how, value }: Condition): string {
  if (how === 'true') return name;
  if (how === 'false') return `not ${name}`;
  return `${name} ${how} ${value || '0'}`;
}
