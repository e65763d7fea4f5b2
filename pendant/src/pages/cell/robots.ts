/** The robots of the catalogue, and a search among them. No side effects. */

export interface CatalogueEntry {
  id: string;
  maker: string;
  model: string;
  title: string;
  axes: number;
  /** m, kg; null if the data sheet does not state it. */
  reach: number | null;
  payload: number | null;
  mass?: number | null;
  picture?: string;
}
export interface Wish {
  words: string;
  maker: string;
  axes: string;
  /** Minimum values, m and kg; '' means any. */
  reach: string;
  payload: string;
  order: 'name' | 'reach' | 'payload';
}
export const kNoWish: Wish = { words: '', maker: '', axes: '', reach: '', payload: '', order: 'name' };

const atLeast = (value: number | null | undefined, wanted: string) => wanted === '' || (value ?? -Infinity) >= Number(wanted);

/** The robots that match all criteria. A robot without a figure does not match a criterion for it. */
export function fitting(all: CatalogueEntry[], wish: Wish): CatalogueEntry[] {
  const words = wish.words.toLowerCase().split(/[\s_/]+/).filter(Boolean);
  const found = all.filter((each) => {
    const text = `${each.id} ${each.title} ${each.maker}`.toLowerCase();
    const plain = text.replace(/[_\s-]+/g, '');
    return (
      words.every((word) => text.includes(word) || plain.includes(word)) &&
      (wish.maker === '' || each.maker === wish.maker) &&
      (wish.axes === '' || each.axes === Number(wish.axes)) &&
      atLeast(each.reach, wish.reach) &&
      atLeast(each.payload, wish.payload)
    );
  });
  const by = wish.order;
  if (by !== 'name') found.sort((a, b) => (a[by] ?? Infinity) - (b[by] ?? Infinity));
  return found;
}

export const makersOf = (all: CatalogueEntry[]) => [...new Set(all.map((each) => each.maker))].sort();
export const axesOf = (all: CatalogueEntry[]) => [...new Set(all.map((each) => each.axes))].sort((a, b) => a - b);
