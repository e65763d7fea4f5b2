// A key that sends what only some roles may send asks for that role.
import { expect, it } from 'vitest';

const read = (found: Record<string, unknown>) => found as Record<string, string>;
const protocol = read(import.meta.glob('../../polyarm/protocol/*.hpp', { query: '?raw', import: 'default', eager: true }));
const views = read(import.meta.glob('../src/**/*.tsx', { query: '?raw', import: 'default', eager: true }));
const kAsks = { program: /\bmayProgram\b|mayAs\('program'\)/, administer: /\bmayAdminister\b|mayAs\('administer'\)/ };

/** The role of each request. */
const roles = new Map<string, string>();
for (const text of Object.values(protocol))
  for (const [, name, role] of text.matchAll(/\.name = "([a-z._]+)",\s*\.role = Role::(\w+)/g)) roles.set(name!, role!);

it('asks for the role in every view that sends such a request', () => {
  expect([roles.get('control.switch'), roles.get('points.teach'), roles.get('control.recover')]).toEqual(['administer', 'program', 'operate']);
  const lacking: string[] = [];
  for (const [file, text] of Object.entries(views))
    for (const [, name] of text.matchAll(/\b(?:request|attempt|change|changePoints|longAttempt|restart)(?:<[^>]*>)?\((?:[^()]*, )?'([a-z]+\.[a-z._]+)'/g)) {
      const asks = kAsks[roles.get(name!) as keyof typeof kAsks];
      if (asks && !asks.test(text)) lacking.push(`${file}: ${name}`);
    }
  expect(lacking).toEqual([]);
});
