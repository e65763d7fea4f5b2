/** The cell's points and other data, and the names that a program may use. */
import { computed, effect, signal } from '@preact/signals';
import type { KnownName, PointFacts } from '../wire/requests';
import type { Vec3 } from '../wire/types';
import { type Args, complain, connected, onEvent, request, type RequestName } from './cell';
import { type NamedPose, pointsIn3d } from './preview';

/** `pose` is in the point's own frame, `world` in the world. */
export type DataValue = PointFacts;

export const values = signal<DataValue[]>([]);
export const pointsFile = signal('');
export const dataFiles = signal<string[]>([]);
/** False until the cell has sent its data once. */
export const pointsKnown = signal(false);
export const names = signal<KnownName[]>([]);

export const isPlace = (kind: string) => kind === 'pose' || kind === 'joints';
/** True for the TCP of a tool: a pose on the flange, which is not a place to move to. */
export const isTool = (value: DataValue) => value.kind === 'pose' && value.taught?.frame === 'tool0';
export const places = computed(() => values.value.filter((each) => isPlace(each.kind) && !isTool(each)));
export const frameNames = computed(() => values.value.filter((each) => each.kind === 'pose' && !isTool(each)).map((each) => each.name));

export const groupNames = computed(() => [...new Set(values.value.map((each) => each.group).filter(Boolean))].sort());

export async function loadPoints(): Promise<void> {
  try {
    const answer = await request('points');
    pointsFile.value = answer.file;
    dataFiles.value = answer.files;
    values.value = answer.values;
    pointsKnown.value = true;
    pointsIn3d.value = answer.values.flatMap((v): NamedPose[] => (v.world ? [{ name: v.name, pose: v.world }] : []));
  } catch (error) {
    complain(error);
  }
}

export async function loadNames(): Promise<void> {
  try {
    names.value = (await request('program.names')).names;
  } catch (error) {
    complain(error);
  }
}

/** Number of components that use followPoints(). */
let users = 0;
/**
 * Loads points and names now, and again whenever the cell reports a change. Returns a function that ends
 * this.
 */
export function followPoints(): () => void {
  ++users;
  const end = effect(() => {
    if (!connected.value) return;
    void loadPoints();
    void loadNames();
  });
  return () => {
    --users;
    end();
  };
}
onEvent('points', () => {
  if (users === 0) return;
  void loadPoints();
  void loadNames();
});

export interface TeachWish {
  name: string;
  robot: string;
  kind: 'pose' | 'joints';
  frame?: string;
  file?: string;
  group?: string;
  replace?: boolean;
}
/** Teaches a point. Throws the error of a refused request. */
export async function teach(wish: TeachWish): Promise<void> {
  await request('points.teach', { ...wish });
  await Promise.all([loadPoints(), loadNames()]);
}

/** Sends any change of points, and shows an error. Returns true on success. */
export async function changePoints<Name extends RequestName>(name: Name, args: Args<Name>): Promise<boolean> {
  try {
    await request<RequestName>(name, args);
    await Promise.all([loadPoints(), loadNames()]);
    return true;
  } catch (error) {
    complain(error);
    return false;
  }
}

/** True if the text may be a name in a program and a data file. */
export function goodName(name: string): boolean {
  return /^[A-Za-z_]\w*$/.test(name) && !/^(and|or|not|mod|true|false)$/i.test(name);
}

export const distance = (a: Vec3, b: Vec3) => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
