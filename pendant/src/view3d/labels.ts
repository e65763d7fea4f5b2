/** Where labels stand in the picture: beside their place, and whole inside the view. No side effects. */

/** px: how high labels are in every view, and the distance that they keep from its edges. */
const kHeight = 20;
const kMargin = 4;
/** px: the keys of the picture in its upper right corner. */
const kKeys = [60, 164] as const;
/** Beside and above its place, in widths and heights of the label. */
const kAside = 0.08;
const kAbove = 0.25;

export interface Standing {
  /** px */
  width: number;
  height: number;
  /** The place within the label, from its lower left corner in widths and heights. */
  center: [number, number];
}

/** `at`: px from the lower left corner of the view. `aspect`: the label's width over its height. */
export function standing(at: readonly [number, number], aspect: number, view: readonly [number, number]): Standing {
  const width = Math.max(1, Math.min(aspect * kHeight, view[0] - 2 * kMargin));
  const height = width / aspect;
  const inside = at.every((each, i) => each >= 0 && each <= view[i]!);
  const low = (i: 0 | 1, size: number, away: number, end: number) => {
    const wanted = at[i] + away * size;
    return inside ? Math.max(kMargin, Math.min(wanted, end - kMargin - size)) : wanted;
  };
  const bottom = low(1, height, kAbove, view[1]);
  const right = bottom + height > view[1] - kKeys[1] ? view[0] - kKeys[0] : view[0];
  const left = low(0, width, kAside, right);
  return { width, height, center: [(at[0] - left) / width, (at[1] - bottom) / height] };
}
