/** True if two paths of files of a cell mean the same file; one of them may be only its end. */
export const sameFile = (a: string, b: string) => a !== '' && b !== '' && (a === b || a.endsWith(`/${b}`) || b.endsWith(`/${a}`));

/** Findings of this file, and those of files that it includes. A finding without a file is of this file. */
export function byFile<T extends { file: string }>(all: readonly T[], name: string): { own: T[]; elsewhere: T[] } {
  const isOwn = (each: T) => each.file === '' || sameFile(each.file, name);
  return { own: all.filter(isOwn), elsewhere: all.filter((each) => !isOwn(each)) };
}
