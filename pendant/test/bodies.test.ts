// The bodies of contacts in the picture.
import { describe, expect, it } from 'vitest';
import * as THREE from 'three';
import { nameInPicture } from '../src/view3d/bodies';
import { RobotFigure } from '../src/view3d/figure';
import type { RobotModel } from '../src/wire/types';
import drivers from '../../drivers/mujoco/model_set.cpp?raw';

describe('a body that touches', () => {
  const none = () => undefined;
  it('is found in the picture by the name that the cell gives it', () => {
    expect(nameInPicture('fixture table', none)).toBe('table');
    expect(nameInPicture('part cube_1', none)).toBe('cube_1');
    expect(nameInPicture('arm/forearm_link', none)).toBe('arm/forearm_link');
    expect(nameInPicture('the part held by left', (robot) => (robot === 'left' ? 'cube_2' : undefined))).toBe('cube_2');
    expect(nameInPicture('the part held by left', none)).toBe('');
    for (const name of ['"fixture "', '"part "', '"the part held by "']) expect(drivers).toContain(name);
  });

  it('can be the tool, apart from the link that carries it', () => {
    const pose = { p: [0, 0, 0], q: [0, 0, 0, 1] };
    const box = { shape: 'box', size: [0.1, 0.1, 0.1], origin: pose, color: [1, 1, 1, 1] };
    const model = { root: 'base', links: [{ name: 'base', visuals: [box] }], joints: [], tcp: { link: 'base', ...pose }, tool: { name: 'cup', visuals: [box] } } as unknown as RobotModel;
    const figure = new RobotFigure(model, () => undefined);
    expect(figure.tool.children.filter((each) => each instanceof THREE.Mesh || each.children.length > 0).length).toBe(1);
    expect(figure.tool.parent?.name).toBe('base');
    expect(figure.tool.userData.joint, 'the link is painted without it').toBeTruthy();
  });
});
