/** Where labels stand in the picture: beside their place, and whole inside the view. No side effects. */

/** px: how high labels are in every view, and the distance that they keep from its edges. */
const kHeight = 20;
const kMargin = 4;
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
  const along = (i: 0 | 1, size: number, away: number) => {
    const wanted = at[i] + away * size;
    const low = inside ? Math.max(kMargin, Math.min(wanted, view[i] - kMargin - size)) : wanted;
    return (at[i] - low) / size;
  };
  return { width, height, center: [along(0, width, kAside), along(1, height, kAbove)] };
}
