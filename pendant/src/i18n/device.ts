/**
 * Translates the sentences of drivers. A driver makes one English sentence for each cause, with advice; the
 * cell sends it without a code. The first row that matches says which situation it is.
 */
import { type Key, language, t } from '.';

const kRows: [Key, RegExp][] = [
  ['device.loopSilent', /^the control loop gave no command in time/],
  ['device.jump', /is too far away for one cycle/],
  ['device.tooFast', /was commanded beyond the .{0,13}limit of the driver/],
  ['device.onlyMoves', /takes only moves/],
  ['device.protective', /made a protective stop/],
  ['device.local', /is in local control/],
  ['device.emergency', /is in an emergency stop|pressed the user stop/],
  ['device.guard', /is in a safeguard stop|^(the fence|a guard) of .* is open/],
  ['device.enabling', /enabling switch .* was released/],
  ['device.manual', /is enabled \(T1 or T2\)|is in (manual|teach) mode|is in mode T\d|was switched to mode|is being moved by hand|in play mode without remote/],
  ['device.collision', /stopped (at|for|before) a (collision|contact)|stopped because the robot was touched/],
  ['device.brakes', /its brakes are closed/],
  ['device.starting', /is still starting/],
  ['device.off', /^the (motors|servos|drives) of .* are off|the robot is switched off|its motors are off/],
  ['device.paused', /was paused|is in hold/],
  ['device.programEnded', /was (stopped|ended) there|was stopped without an error|ended or was deselected there|ended though its program runs|job INIT_ROS of .* does not run/],
  ['device.otherProgram', /^another (program|client)|another client moves the robot|runs another program|has a paused program|end other programs that use the robot/],
  ['device.fast', /stopped because a motion was too fast/],
  ['device.notSmooth', /stopped because commands were not smooth/],
  ['device.strayed', /stopped because it was not where it was commanded/],
  ['device.commandsLate', /got no command in time|stopped because commands were missing|answers in a row too late|ran out of points/],
  ['device.unreachable', /cannot be reached|does not answer/],
  ['device.silent', /sends nothing any more|sends no (packets|reports|states)/],
  ['device.closed', /closed (the|a|its) .*(connection|Interface)|closed a connection/],
  ['device.limit', /(stopped|reached) (at )?(a|its) (limit|safety boundary)|stopped at its safety boundary|beyond its software limit/],
  ['device.refused', /refused (the|a step of the) motion|did not take the first command|does not allow motion/],
  ['device.alarm', /(stopped (with|for) (an? )?(alarm|event|message|error))|has (an )?(alarm|error)/],
];

/** The rows, for a test that compares them with the drivers. */
export const kDeviceRows: readonly (readonly [Key, RegExp])[] = kRows;

/** Numbers by which a person finds the cause in the manual: C31, SRVO-001, alarm 4107. */
const kNumbers = /\b(C\d+|[A-Z]{4}-\d{3}|(?:alarm|event) \d+)\b/;

/** What the cell puts before a driver's sentence if a component refuses a step. */
const kStep = /^the hardware component '[^']*' could not be [^:]*: /;

/** The driver's sentence in the page's language; the driver's own words in English, or if no row matches. */
export function deviceWords(own: string): string {
  if (language.value === 'en') return own;
  const reason = own.replace(kStep, '');
  const row = kRows.find(([, pattern]) => pattern.test(reason));
  if (!row) return own;
  const address = /\b(?:controller|robot) at ([^\s:,;()]+)/.exec(own)?.[1];
  const where = address ? t('device.at', { address }) : t('device.controller');
  const text = t(row[0], { where }).replace(/\bde el /g, 'del ');  // Spanish
  const number = kNumbers.exec(own)?.[1];
  return text.charAt(0).toUpperCase() + text.slice(1) + (number ? ` (${number})` : '');
}
