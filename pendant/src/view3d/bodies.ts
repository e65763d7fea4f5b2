/** The bodies of the picture by the names that contacts use. No side effects. */

/**
 * The name of the body among those of the picture: `table` for `fixture table`, `cube` for `part cube`, and for `the part held by
 * arm` the part that `heldBy` names. Links and tools, `arm/forearm_link` and `arm/tool`, are called the same.
 */
export function nameInPicture(body: string, heldBy: (robot: string) => string | undefined): string {
  const held = /^the part held by (.+)$/.exec(body)?.[1];
  if (held !== undefined) return heldBy(held) ?? '';
  return body.replace(/^(?:fixture|part) /, '');
}
