import { afterEach, describe, expect, it, vi } from 'vitest';
vi.mock('../src/state/settings', () => ({ settings: { degrees: { value: true } } }));
vi.mock('../src/i18n', () => ({ number: String }));
import { settings } from '../src/state/settings';
import { decimalsOf, nameParts, placeIn, shortened, shownIn, withinSentence } from '../src/ui/format';

describe('units of curves', () => {
  afterEach(() => (settings.degrees.value = true));
  it('are those of the pages', () => {
    expect(shownIn('m')).toEqual({ unit: 'mm', factor: 1000 });
    expect(shownIn('m/s')).toEqual({ unit: 'mm/s', factor: 1000 });
    expect(shownIn('rad/s2').unit).toBe('°/s²');
    expect(shownIn('rad').factor).toBeCloseTo(180 / Math.PI);
    expect(shownIn('Nm')).toEqual({ unit: 'Nm', factor: 1 });
    expect(shownIn('')).toEqual({ unit: '', factor: 1 });
  });
  it('are radians where those are chosen', () => {
    settings.degrees.value = false;
    expect(shownIn('rad/s')).toEqual({ unit: 'rad/s', factor: 1 });
    expect(shownIn('m').unit).toBe('mm');
  });
});

describe('figures of an axis', () => {
  it('have as many decimals as tell them apart', () => {
    expect([1, 5, 0.5, 0.25, 0.1, 0.00025].map(decimalsOf)).toEqual([0, 0, 1, 2, 1, 5]);
  });
});

describe('values of a program', () => {
  it('are read with six digits at most', () => {
    expect(shortened('[xyz(0.6799999999999999, 0.29, -0.041) rpy(3.141592653589793, 0, 0)]')).toBe('[xyz(0.68, 0.29, -0.041) rpy(3.14159, 0, 0)]');
    expect(shortened('1e-17')).toBe('1e-17');
    expect(shortened('12')).toBe('12');
  });
  it('are texts as they are', () => expect(shortened('["1.23456789", x_1.23456789]')).toBe('["1.23456789", x_1.23456789]'));
});

describe('words', () => {
  it('of a list fit into a sentence', () => {
    expect(withinSentence('A place on the x axis')).toBe('a place on the x axis');
    expect(withinSentence('Un lugar en el eje x')).toBe('un lugar en el eje x');
  });
  it('of a long name may stand on two lines', () => {
    expect(nameParts('DeactivateGripper')).toEqual(['Deactivate', 'Gripper']);
    expect(nameParts('part_held_2')).toEqual(['part_', 'held_', '2']);
    expect(nameParts('PLC')).toEqual(['PLC']);
    expect(nameParts('VálvulaÁgil')).toEqual(['Válvula', 'Ágil']);
  });
});

describe('places in files', () => {
  it('are without the folder of the cell', () => {
    expect(placeIn('/home/me/cells/press', '/home/me/cells/press/lib/grippers.script:3')).toBe('lib/grippers.script:3');
    expect(placeIn('/home/me/cells/press', '/home/me/cells/press_2/job.script:3')).toBe('/home/me/cells/press_2/job.script:3');
    expect(placeIn('', 'job.script:3')).toBe('job.script:3');
  });
});
