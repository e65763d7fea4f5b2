import { expect, test } from 'vitest';
import { outermostLoop } from '../src/pages/run/loop';

test('the outermost loop is the first while that has a condition', () => {
  expect(outermostLoop('load data\nmoveto p0\nwhile Repeat\n  while Inner\n  end\nend\n')).toEqual({ line: 3, source: 'while Repeat' });
  expect(outermostLoop('  while a > 1 # as long as it is\nend')).toEqual({ line: 1, source: 'while a > 1' });
});

test('a comment, a name that begins so and a text without a loop have none', () => {
  expect(outermostLoop('# while Repeat\nset whileAway = 1\nmoveto p0\n')).toBeNull();
  expect(outermostLoop('while # nothing is said\n')).toBeNull();
});

test('a loop that something else can end in its first pass is not said to have ended by its condition', () => {
  expect(outermostLoop('while true\n  break\nend\n')).toBeNull();
  expect(outermostLoop('while Repeat\n  if Full\n    break\n  end\nend\n')).toBeNull();
  expect(outermostLoop('while true\nend\n')).toBeNull();
});

test('a loop of a function is not the one that counts', () => {
  expect(outermostLoop('func look()\n  while not Seen\n  end\nend\nwhile Repeat\n  look()\nend\n')).toEqual({ line: 5, source: 'while Repeat' });
});
