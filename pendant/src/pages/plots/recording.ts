/** The recording of the cell: the text of its state, and the file without its folder. */
import { number, t } from '../../i18n';
import { duration } from '../../ui/format';
import type { RecordFacts } from '../../wire/requests';

export const fileOf = (facts: RecordFacts): string => facts.file.split('/').pop() ?? '';

/** 12 kB, 3.4 MB. */
export function sizeText(bytes: number): string {
  return bytes < 1e6 ? `${number(Math.ceil(bytes / 1e3), 0)} kB` : `${number(bytes / 1e6, 1)} MB`;
}

/** What is recorded now, or was recorded: file, time and size, and what was lost. */
export function recordWords(facts: RecordFacts): string {
  const words = { file: fileOf(facts), time: duration(facts.seconds), size: sizeText(facts.bytes) };
  const main = t(facts.recording ? 'plots.recording' : 'plots.recorded', words);
  return facts.lost > 0 ? `${main} · ${t('plots.recordLost', { count: facts.lost })}` : main;
}
