/** The open page: the part of the address after #/. */
import { signal } from '@preact/signals';
import { pages } from '../pages';

function fromAddress(): string {
  const wanted = location.hash.replace(/^#\/?/, '').split('/')[0] ?? '';
  return pages.some((page) => page.id === wanted) ? wanted : pages[0]!.id;
}

export const pageId = signal(fromAddress());
addEventListener('hashchange', () => (pageId.value = fromAddress()));

export function go(id: string): void {
  location.hash = `#/${id}`;
}
