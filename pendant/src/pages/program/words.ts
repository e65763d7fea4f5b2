/** The words of the language, from the cell; until the cell has sent them, the words that colours need. */
import { signal } from '@preact/signals';
import { request } from '../../state/cell';
import { type Language, knownWords } from './knownWords';

export const language = signal<Language>(knownWords);

let asked = false;
export async function loadWords(): Promise<void> {
  if (asked) return;
  asked = true;
  try {
    language.value = await request('language.words');
  } catch {
    asked = false;
  }
}
