/** True if two paths of files of a cell mean the same file; one of them may be only its end. */
export const sameFile = (a: string, b: string) => a !== '' && b !== '' && (a === b || a.endsWith(`/${b}`) || b.endsWith(`/${a}`));
