import { describe, expect, it, vi } from 'vitest';
const sent = vi.hoisted(() => [] as { name: string; offset: number; data: string; last: boolean }[]);
vi.mock('../src/state/cell', () => ({
  request: (_: string, args: { name: string; offset: number; data: string; last: boolean }) => {
    sent.push(args);
    const mesh = args.last && args.name.endsWith('.stl') ? { size: [40, 20, 15], lower: [0, 0, -5], triangles: 2, metres: false, likely: 'mm' } : null;
    return Promise.resolve({ bytes: 0, file: `meshes/${args.name}`, mesh });
  },
}));
import { base64, fileName, isMesh, place, sceneName, upload } from '../src/pages/cell/mesh';

describe('a mesh for the scene', () => {
  it('gets a name that the scene takes', () => {
    expect(sceneName('meshes/my part-2.STL')).toBe('my_part_2');
    expect(sceneName('meshes/40mm.stl')).toBe('mesh_40mm');
    expect(fileName('../größe (1).stl')).toBe('_gr__e _1_.stl');
    expect(isMesh('a.STEP')).toBe(true);
    expect(isMesh('a.step.exe')).toBe(false);
  });
  it('stands on the floor, whatever its unit', () => {
    const mesh = { file: 'meshes/a.stl', size: [40, 20, 15], lower: [0, 0, -5], triangles: 2, metres: false, likely: 'mm' } as const;
    expect(place({ ...mesh, size: [...mesh.size], lower: [...mesh.lower] }, 'mm')).toEqual([0.5, 0, 0.005]);
    expect(place({ ...mesh, size: [...mesh.size], lower: [...mesh.lower] }, 'in')[2]).toBeCloseTo(0.127);
    expect(place({ ...mesh, metres: true, size: [...mesh.size], lower: [...mesh.lower] }, 'mm')[2]).toBe(5);
  });
  it('is sent in pieces, after its images', async () => {
    const bytes = new Uint8Array(900_000).map((_, i) => i % 251);
    const shares: number[] = [];
    const got = await upload([new File([bytes], 'a.stl'), new File(['x'], 'notes.txt'), new File(['png'], 'a.png')], (share) => shares.push(share));
    expect(sent.map((each) => [each.name, each.offset, each.last])).toEqual([
      ['a.png', 0, true],
      ['a.stl', 0, false],
      ['a.stl', 393216, false],
      ['a.stl', 786432, true],
    ]);
    const back = sent.slice(1).map((each) => Uint8Array.from(atob(each.data), (c) => c.charCodeAt(0)));
    expect(back.reduce((sum, each) => sum + each.length, 0)).toBe(bytes.length);
    expect(back[1]![0]).toBe(393216 % 251);
    expect(shares.at(-1)).toBe(1);
    expect(got).toHaveLength(1);
    expect(got[0]!.file).toBe('meshes/a.stl');
  });
  it('is coded as base64', () => {
    expect(base64(new Uint8Array([0, 255, 16]))).toBe('AP8Q');
    expect(base64(new Uint8Array([]))).toBe('');
  });
});
