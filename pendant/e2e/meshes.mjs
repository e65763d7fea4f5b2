// A description with meshes of its own: what can be read is shown, what cannot is told and shown by the plain shape beside it.
import assert from 'node:assert/strict';
import { mkdirSync, truncateSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { deflateSync } from 'node:zlib';
import { go, picture } from './browser.mjs';
import { until } from './cell.mjs';
import { suite } from './suite.mjs';

/** The twelve triangles of a box about the origin, as corners. */
function corners([x, y, z]) {
  const at = (i) => [i & 1 ? x / 2 : -x / 2, i & 2 ? y / 2 : -y / 2, i & 4 ? z / 2 : -z / 2];
  const sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
  return sides.flatMap(([a, b, c, d]) => [a, b, c, a, c, d].map(at));
}

function stl(size, told) {
  const list = corners(size);
  const out = Buffer.alloc(84 + (50 * list.length) / 3);
  out.writeUInt32LE(told ?? list.length / 3, 80);
  list.forEach((corner, i) => corner.forEach((v, k) => out.writeFloatLE(v, 84 + 50 * Math.floor(i / 3) + 12 * (1 + (i % 3)) + 4 * k)));
  return out;
}
/** With an image on each triangle. */
const obj = (size) => {
  const list = corners(size);
  const face = (i) => `f ${[1, 2, 3].map((k) => `${3 * i + k}/${k}`).join(' ')}`;
  const head = ['mtllib post.mtl', 'vt 0 0', 'vt 1 0', 'vt 1 1', 'usemtl checks'];
  return [...head, ...list.map((c) => `v ${c.join(' ')}`), ...Array.from({ length: list.length / 3 }, (_, i) => face(i)), ''].join('\n');
};
/** Squares in two colours, as PNG. */
function png(size) {
  const crc = (bytes) => {
    let sum = ~0;
    for (const byte of bytes) {
      sum ^= byte;
      for (let k = 0; k < 8; ++k) sum = (sum >>> 1) ^ (sum & 1 ? 0xedb88320 : 0);
    }
    return ~sum >>> 0;
  };
  const chunk = (name, data) => {
    const body = Buffer.concat([Buffer.from(name), data]);
    const out = Buffer.alloc(body.length + 8);
    out.writeUInt32BE(data.length, 0);
    body.copy(out, 4);
    out.writeUInt32BE(crc(body), body.length + 4);
    return out;
  };
  const head = Buffer.from([0, 0, 0, size, 0, 0, 0, size, 8, 2, 0, 0, 0]);
  const rows = Buffer.concat(Array.from({ length: size }, (_, y) =>
    Buffer.from([0, ...Array.from({ length: size }, (_, x) => ((x >> 2) + (y >> 2)) % 2 ? [240, 180, 40] : [40, 60, 160]).flat()])));
  return Buffer.concat([Buffer.from('\x89PNG\r\n\x1a\n', 'latin1'), chunk('IHDR', head), chunk('IDAT', deflateSync(rows)), chunk('IEND', Buffer.alloc(0))]);
}
/** In millimetres, and red. */
const dae = (size) => {
  const list = corners(size).map((corner) => corner.map((v) => 1000 * v));
  return `<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="millimeter" meter="0.001"/><up_axis>Z_UP</up_axis></asset>
<library_effects><effect id="e"><profile_COMMON><technique sid="t"><lambert><diffuse><color>0.8 0.1 0.1 1</color></diffuse></lambert></technique></profile_COMMON></effect></library_effects>
<library_materials><material id="m"><instance_effect url="#e"/></material></library_materials>
<library_geometries><geometry id="g"><mesh><source id="p"><float_array id="pa" count="${3 * list.length}">${list.flat().join(' ')}</float_array>
<technique_common><accessor source="#pa" count="${list.length}" stride="3"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="${list.length / 3}" material="m"><input semantic="VERTEX" source="#v" offset="0"/><p>${list.map((_, i) => i).join(' ')}</p></triangles></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node><instance_geometry url="#g"><bind_material><technique_common><instance_material symbol="m" target="#m"/></technique_common></bind_material></instance_geometry></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>`;
};

const kLinks = [['base', 'base.stl'], ['post', 'post.obj'], ['arm', 'arm.dae'], ['broken', 'broken.stl'], ['missing', 'gone.stl'], ['huge', 'huge.stl']];
const kSize = [0.12, 0.12, 0.2];

function urdf() {
  const link = ([name, file]) => `<link name="${name}"><visual><origin xyz="0 0 0.1"/><geometry><mesh filename="meshes/${file}"/></geometry></visual>
<collision><origin xyz="0 0 0.1"/><geometry><cylinder radius="0.05" length="0.2"/></geometry></collision></link>`;
  const joint = (i) => `<joint name="joint_${i}" type="revolute"><origin xyz="0 0 0.22"/><parent link="${kLinks[i - 1][0]}"/><child link="${kLinks[i][0]}"/>
<axis xyz="${i % 2 ? '0 0 1' : '0 1 0'}"/><limit lower="-2" upper="2" velocity="2" effort="50"/></joint>`;
  return `<robot name="own">${kLinks.map(link).join('')}${[1, 2, 3, 4, 5].map(joint).join('')}</robot>`;
}

const { at, test, holdKey, atRest } = suite({
  example: null,
  change: (folder) => {
    mkdirSync(join(folder, 'meshes'));
    const write = (name, content) => writeFileSync(join(folder, name), content);
    write('own.urdf', urdf());
    write('cell.yaml', 'polyarm: cell/1\nrobots:\n  own: {model: own.urdf, hardware: mock}\n');
    write('meshes/base.stl', stl(kSize));
    write('meshes/post.obj', obj(kSize));
    write('meshes/post.mtl', 'newmtl checks\nKd 0.8 0.8 0.8\nmap_Kd checks.png\n');
    write('meshes/checks.png', png(32));
    write('meshes/arm.dae', dae(kSize));
    write('meshes/broken.stl', stl(kSize, 1000));
    write('meshes/huge.stl', '');
    truncateSync(join(folder, 'meshes/huge.stl'), 300e6);
  },
});
let page;

test('shows meshes that can be read, and the plain shape of those that cannot', async () => {
  const { cell } = at;
  page = await at.open();
  await page.getByRole('button', { name: /^In control/ }).waitFor();
  const model = await (await fetch(`http://127.0.0.1:${cell.port}/api/model/own`, { headers: { Authorization: `Bearer ${cell.token}` } })).json();
  const address = model.links[0].visuals[0].mesh;
  assert.ok(model.links.every((link) => link.visuals.some((each) => each.mesh === address)), 'one GLB');
  const answer = await fetch(`http://127.0.0.1:${cell.port}${address}`, { headers: { Authorization: `Bearer ${cell.token}` } });
  const bytes = Buffer.from(await answer.arrayBuffer());
  assert.equal(bytes.toString('latin1', 0, 4), 'glTF');
  const glb = JSON.parse(bytes.toString('utf8', 20, 20 + bytes.readUInt32LE(12)));
  const heights = Object.fromEntries(glb.nodes.filter((node) => node.mesh !== undefined).map((node) => {
    const { min, max } = glb.accessors[glb.meshes[node.mesh].primitives[0].attributes.POSITION];
    return [node.name, [0, 1, 2].map((k) => Math.round(1000 * (max[k] - min[k])))];
  }));
  for (const name of ['base', 'post', 'arm']) assert.deepEqual(heights[name], [120, 120, 200], `${name}, mm`);
  for (const name of ['broken', 'missing', 'huge']) assert.deepEqual(heights[name], [100, 100, 200], `${name}: its cylinder, mm`);
  assert.equal(glb.images?.length, 1, 'the image of post');
  const image = glb.bufferViews[glb.images[0].bufferView];
  const begin = 28 + bytes.readUInt32LE(12) + image.byteOffset;
  assert.ok(bytes.subarray(begin, begin + image.byteLength).equals(png(32)), 'as its file has it');
  await until(async () => (await page.getByRole('button', { name: 'Views' }).isVisible()), 60, 'the view');
  await picture(page, 'meshes');
});

test('says of each mesh that cannot be shown which it is, why, and what to do', async () => {
  await go(page, 'Health');
  await page.getByRole('main').getByRole('radiogroup').first().getByText(/^Alarms/).click();
  const said = page.getByRole('main');
  await said.getByText(/the link 'broken' is shown by what it collides with: the mesh .*broken\.stl is not a whole STL/).waitFor();
  await said.getByText(/the link 'missing' is shown by what it collides with: .*gone\.stl/).waitFor();
  await said.getByText(/the link 'huge' is shown by what it collides with: .*huge\.stl is larger than 128 MB/).waitFor();
  await picture(page, 'meshes-alarms');
  await page.reload();
  await page.getByRole('button', { name: /^In control/ }).waitFor();
  await go(page, 'Health');
  await said.getByText(/the link 'broken'/).waitFor();
  assert.equal(await said.getByText(/the link 'broken'/).count(), 1, 'once, however often the page is opened');
});

test('turns the meshes with their joints', async () => {
  await go(page, 'Move');
  const view = page.getByRole('region', { name: 'Robot view' });
  await view.getByRole('button', { name: 'Views' }).waitFor();
  const first = await view.screenshot();
  const where = () => at.watcher.value('own/joint_2/position');
  await holdKey(page.getByRole('button', { name: '2 plus', exact: true }), () => where() > 0.2, 'motion');
  await page.mouse.up();
  await atRest();
  await until(async () => !first.equals(await view.screenshot()), 60, 'another picture');
  await picture(page, 'meshes-turned');
  assert.deepEqual(page.problems, []);
});
