import { mkdtempSync, readFileSync, readdirSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { dirname, join, relative } from 'node:path';
import { fileURLToPath } from 'node:url';
import { afterAll, beforeAll, expect, test } from 'vitest';
import { buildHelp } from '../help/build.mjs';

let site = '';
beforeAll(() => {
  site = mkdtempSync(join(tmpdir(), 'polyarm-help-'));
  buildHelp(site);
});
afterAll(() => rmSync(site, { recursive: true, force: true }));

function files(folder, ending) {
  return readdirSync(folder, { recursive: true })
    .filter((name) => name.endsWith(ending))
    .map((name) => join(folder, name));
}

const idsOf = (file) => new Set([...readFileSync(file, 'utf8').matchAll(/ id="([^"]+)"/g)].map((found) => found[1]));

test('every link and picture of the site leads to a file and a heading of it', () => {
  const bad = [];
  for (const file of files(site, '.html'))
    for (const found of readFileSync(file, 'utf8').matchAll(/ (?:href|src)="([^"]*)"/g)) {
      const [path, anchor] = found[1].split('#');
      if (/^[a-z]+:/.test(path)) continue;
      const target = path ? join(dirname(file), path) : file;
      try {
        if (anchor && !idsOf(target).has(anchor) && anchor !== 'content') bad.push(`${relative(site, file)}: no heading #${anchor} in ${path}`);
        readFileSync(target);
      } catch {
        bad.push(`${relative(site, file)}: no ${found[1]}`);
      }
    }
  expect(bad).toEqual([]);
});

test('each page of the pendant opens help that is there', () => {
  const source = readFileSync(fileURLToPath(new URL('../src/pages/index.ts', import.meta.url)), 'utf8');
  const helps = [...source.matchAll(/help: '([^']+)'/g)].map((found) => found[1]);
  expect(helps.length).toBe(8);
  for (const help of helps) {
    const [path, anchor] = help.split('#');
    expect(anchor ? idsOf(join(site, path)).has(anchor) : readFileSync(join(site, path)).length > 0, help).toBe(true);
  }
});

test('the search index is code without a network, and finds a page by its words', () => {
  const script = readFileSync(join(site, 'search-index.js'), 'utf8');
  expect(script.startsWith('window.polyarmIndex = {')).toBe(true);
  expect(script).toContain('stops.html#after-a-contact');
});

test('a code block shows nothing of what only its test reads', () => {
  for (const file of files(site, '.html')) expect(readFileSync(file, 'utf8')).not.toMatch(/language-[a-z]+ (run|save|append|check|shown)/);
});
