/** The words of the language as the cell tells them; until it has, those that colours need. */
import { signal } from '@preact/signals';
import { request } from '../../state/cell';

export interface LanguageWord {
  name: string;
  role: 'statement' | 'branch' | 'closer' | 'clause' | 'reserved' | string;
  form: string;
  meaning: string;
  in_tests: boolean;
}
export interface LanguageFunction {
  name: string;
  signature: string;
  meaning: string;
  in_tests: boolean;
}
export interface Language {
  words: LanguageWord[];
  functions: LanguageFunction[];
}

const word = (role: string) => (name: string) => ({ name, role, form: name, meaning: '', in_tests: false });
const first: Language = {
  words: [
    ...('load import set let include log moveto movej movel movec drive turn use wait while for if func return break ' +
      'continue stop hold try raise retry task together meet lock when').split(' ').map(word('statement')),
    ...'elif else on'.split(' ').map(word('branch')),
    ...'end endwhile endif endfor'.split(' ').map(word('closer')),
    ...'robot tool frame payload near speed accel blend duration exact smooth until at timeout in'.split(' ').map(word('clause')),
    ...'and or not mod true false'.split(' ').map(word('reserved')),
  ],
  functions: ('length abs min max round floor ceil sqrt sin cos tan asin acos atan atan2 pose quat joints offset tool_offset ' +
    'inverse distance interpolate pallet here ask').split(' ').map((name) => ({ name, signature: `${name}(…)`, meaning: '', in_tests: false })),
};
export const language = signal<Language>(first);

let asked = false;
export async function loadWords(): Promise<void> {
  if (asked) return;
  asked = true;
  try {
    language.value = await request<Language>('language.words');
  } catch {
    asked = false;
  }
}
