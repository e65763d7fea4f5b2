import { describe, expect, it } from 'vitest';
import { byFile, sameFile } from '../src/pages/program/sameFile';

describe('files of a cell', () => {
  it('are the same by the end of their path', () => {
    expect(sameFile('/cells/press/job.script', 'job.script')).toBe(true);
    expect(sameFile('/cells/press/my_job.script', 'job.script')).toBe(false);
    expect(sameFile('', 'job.script')).toBe(false);
  });
  it('divide what the checker found: no error of an included file is left out', () => {
    const all = [{ file: '', line: 1 }, { file: '/cells/press/job.script', line: 2 }, { file: '/cells/press/lib/grippers.script', line: 3 }];
    expect(byFile(all, 'job.script')).toEqual({ own: [all[0], all[1]], elsewhere: [all[2]] });
  });
});
