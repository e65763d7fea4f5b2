/** Data that pages add to the robot's picture: points of a list, paths and problems of a dry run. */
import { signal } from '@preact/signals';
import type { Pose, Vec3 } from '../wire/types';

export interface NamedPose {
  name: string;
  pose: Pose;
}
export interface DryPath {
  robot: string;
  line: number;
  points: Vec3[];
}
export interface DryProblem {
  line: number;
  text: string;
  robot: string;
  at: Vec3 | null;
}

/** Poses in the world that are drawn as small frames with their names. */
export const pointsIn3d = signal<NamedPose[]>([]);
/** The names of those that are selected on the page. */
export const chosenPoints = signal<string[]>([]);
export const dryPaths = signal<DryPath[]>([]);
export const problemsIn3d = signal<DryProblem[]>([]);
