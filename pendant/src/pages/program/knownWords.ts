/** The words of the language that colours and steps need. No side effects. */

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
/**
 * Used until the cell has sent its own words. A test compares them with the reference page, which is
 * generated from the parser's list.
 */
export const knownWords: Language = {
  words: [
    ...('load import set let include log moveto movej movel movec speedj speedl drive turn use wait while for if func ' +
      'return break continue stop hold try on raise retry task together meet lock when trap every pulse').split(' ').map(word('statement')),
    ...'elif else'.split(' ').map(word('branch')),
    ...('end endwhile endif endfor endfunc endtry endtask endtogether endlock endwhen endtrap endevery endon endwait endmeet endmove endtest').split(' ').map(word('closer')),
    ...'robot tool frame payload near around speed accel blend duration exact smooth touch until at'.split(' ').map(word('clause')),
    ...'and or not mod true false'.split(' ').map(word('reserved')),
  ],
  functions: ('length abs min max round floor ceil sqrt sin cos tan asin acos atan atan2 pose quat joints offset tool_offset ' +
    'with inverse distance interpolate pallet here ask here_joints ik fk random clock force wrench zero_force met travelled comply stiff next_part waiting_parts missed_parts add_part rows_of is_connected has_line next_line send_text format text number is_number split join ' +
    'trim upper lower find replace slice').split(' ').map((name) => ({ name, signature: `${name}(…)`, meaning: '', in_tests: false })),
};
