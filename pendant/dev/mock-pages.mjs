// Requests of the pages Program, Points, Signals, Health and Cell, for the made-up cell of mock.mjs.
import { createHash } from 'node:crypto';
import { readFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import { forward, joints } from './kinematics.mjs';

const example = (name) => readFileSync(fileURLToPath(new URL(`../../examples/pick_and_place/${name}`, import.meta.url)), 'utf8');
const hash = (text) => createHash('sha1').update(text).digest('hex').slice(0, 12);
const fail = (code, what, advice = '') => { throw Object.assign(new Error(what), { code, advice }); };
const kinds = { script: 'program', points: 'points', data: 'data', yaml: 'scene' };

export function pageRequests({ cell, tell, refuse = fail }) {
  const files = new Map();
  for (const name of ['PAPscript.script', 'flowing.script', 'plc.script', 'cycledata.data', 'PAPpoints.points', 'signals.yaml', 'scene.yaml', 'cell.yaml'])
    files.set(name, { text: example(name), modified_s: Date.now() / 1000 - 86400, versions: [], draft: null });
  files.get('flowing.script').versions.push({ number: 1, when: '2026-11-20 17:03:11', what: 'saved', text: files.get('flowing.script').text.replace('50mm', '20mm') });
  const fileOf = (name) => files.get(name) ?? refuse('no-file', `there is no file '${name}'`);
  const down = [1, 0, 0, 0];
  const values = new Map();
  const point = (name, p, extra = {}) => values.set(name, { name, kind: 'pose', file: 'PAPpoints.points', text: `xyz(${p})`, value: null, pose: { p, q: down }, world: { p, q: down }, joints: null, taught: { frame: '', tool: 'suction_cup', robot: 'universal_robots/ur3' }, group: '', ...extra });
  point('p0', [0.27, 0, 0.22]); point('PrePick', [0.3, 0.15, 0.14], { group: 'pick' }); point('Pick', [0.3, 0.15, 0.04], { group: 'pick' });
  point('Pass1', [0.3, 0.08, 0.2]); point('Pass2', [0.3, -0.08, 0.2]); point('PrePlace', [0.3, -0.15, 0.14], { group: 'place' }); point('Place', [0.3, -0.15, 0.045], { group: 'place' });
  values.set('Home', { name: 'Home', kind: 'joints', file: 'PAPpoints.points', text: '', value: null, pose: null, world: null, joints: Object.fromEntries(joints.map((j, i) => [j.name, [0, -1.4, 1.6, 1.37, 0, 0][i]])), taught: null, group: '' });
  const data = (name, kind, value, file = 'cycledata.data') => values.set(name, { name, kind, file, text: String(value), value, pose: null, world: null, joints: null, taught: null, group: '' });
  data('Repeat', 'boolean', true); data('ScriptFile', 'text', 'PAPscript'); data('Speed', 'number', 0.25);
  let undone = [];
  const keep = (what) => undone.push({ what, values: structuredClone([...values]) });
  const changed = () => tell({ event: 'points' });
  const here = () => { const at = forward(cell.q); return { tcp: at, flange: { p: [at.p[0], at.p[1], at.p[2] + 0.06], q: at.q }, joints: Object.fromEntries(joints.map((j, i) => [j.name, cell.q[i]])), tool: 'suction_cup' }; };
  const tag = (name, type, value, direction, source, by, extra = {}) => ({ name, type, unit: '', value, text: String(value), direction, source, quality: 'good', forced: false, tag: true, changed_s: cell.time, changed_by: by, output: null, rules: {}, ...extra });
  const tags = new Map([
    tag('Vacuum', 'boolean', false, 'out', 'arm/tool/vacuum', 'plc', { rules: { on_stop: false } }), tag('PartHeld', 'boolean', false, 'in', 'arm/tool/part_present', 'arm/tool/part_present'),
    tag('Feed', 'number', 1, 'out', 'scene/feeder/feed', 'plc'), tag('FeederLeft', 'number', 2, 'in', 'scene/feeder/remaining', 'scene'),
    tag('Cycle', 'number', 1, 'in', 'program/pass', 'program'), tag('Temperature', 'number', 41.25, 'in', 'link plc', 'plc', { unit: '°C', quality: 'stale' }),
    tag('Repeat', 'boolean', true, 'internal', 'data cycledata', 'plc', { tag: false }), tag('ActivateGripper', 'boolean', false, 'internal', 'data cycledata', 'program', { tag: false }),
    tag('GripperActive', 'boolean', false, 'internal', 'data cycledata', 'plc', { tag: false }), tag('ScriptFile', 'text', 'PAPscript', 'internal', 'data cycledata', '', { tag: false }),
  ].map((each) => [each.name, each]));
  const tellTag = (each) => tell({ event: 'tags', full: false, values: { [each.name]: { value: each.value, text: each.text, quality: each.quality, forced: each.forced, by: each.changed_by, since: each.changed_s } } });
  const put = (name, value, by) => { const each = tags.get(name) ?? refuse('unknown-name', `there is no tag '${name}'`); Object.assign(each, { value, text: String(value), changed_by: by, changed_s: cell.time }); tellTag(each); return each; };
  const keywords = 'load import set let include log moveto movej movel movec use wait while for if elif else end endwhile endif func return break continue stop hold try on raise retry task together meet lock when'.split(' ');
  function check(text) {
    const problems = [];
    text.split('\n').forEach((raw, i) => {
      const line = raw.replace(/#.*/, '').trim();
      const word = /^[A-Za-z_]\w*/.exec(line)?.[0] ?? '';
      if (line && !keywords.includes(word.toLowerCase()) && !/\(/.test(line)) problems.push({ severity: 'error', code: 'unknown-word', what: `'${word}' is no statement`, advice: 'did you mean movej?', file: '', line: i + 1, column: raw.indexOf(word) + 1 });
      const move = /^(move[tojlc]+)\s+(\w+)/.exec(line);
      if (move && move[2] !== 'offset' && !values.has(move[2]) && !/^\[/.test(move[2])) problems.push({ severity: 'error', code: 'unknown-name', what: `there is no point '${move[2]}'`, advice: 'the nearest is Place', file: '', line: i + 1, column: raw.indexOf(move[2]) + 1 });
      if (/^wait time/.test(line) && i < 7) problems.push({ severity: 'warning', code: 'slow', what: 'a timer waits for what a signal could tell', advice: '', file: '', line: i + 1, column: 1 });
    });
    return problems;
  }
  const histogram = (middle, spread, n = 9e5) => ({ p50: middle, p99: middle + 3 * spread, max: middle + 12 * spread, samples: n,
    buckets: Array.from({ length: 40 }, (_, i) => ({ to_us: middle / 2 + i * spread, count: Math.round(n * Math.exp(-(((middle / 2 + i * spread - middle) / (2 * spread)) ** 2))) })) });
  const hardware = [{ name: 'arm', type: 'system', plugin: 'mujoco', group: '', state: 'active', being: 'active', rate: 500, async: false, missed: 0, states: joints.map((j) => `arm/${j.name}/position`), commands: joints.map((j) => ({ name: `arm/${j.name}/position`, claimed_by: 'arm_motion' })) },
    { name: 'gripper', type: 'actuator', plugin: 'suction', group: '', state: 'inactive', being: 'inactive', rate: 100, async: true, missed: 3, states: ['arm/tool/part_present'], commands: [{ name: 'arm/tool/vacuum', claimed_by: '' }] }];
  const controllers = [
    { name: 'arm_motion', type: 'polyarm/motion', state: 'active', chained: false, async: false, stale: false, rate: 500, updates: 180000, missed: 0, claimed: joints.map((j) => `arm/${j.name}/position`), commands: [], states: [], references: [], inputs: [] },
    { name: 'joint_state_broadcaster', type: 'joint_state_broadcaster/JointStateBroadcaster', state: 'active', chained: false, async: false, stale: false, rate: 100, updates: 36000, missed: 0, claimed: [], commands: [], states: [], references: [], inputs: [] },
    { name: 'forward_position', type: 'forward_command_controller/ForwardCommandController', state: 'inactive', chained: false, async: false, stale: false, rate: 500, updates: 0, missed: 0, claimed: [], commands: [], states: [], references: [], inputs: [] },
  ];
  const named = (list, name) => list.find((each) => each.name === name) ?? refuse('unknown-name', `there is no '${name}'`);
  const makers = [['universal_robots', 'ur3', 0.5, 3], ['universal_robots', 'ur5e', 0.85, 5], ['universal_robots', 'ur10e', 1.3, 12.5], ['abb', 'irb_120', 0.58, 3], ['abb', 'irb_1200', 0.9, 5], ['fanuc', 'lr_mate_200id', 0.717, 7], ['kuka', 'lbr_iiwa_14', 0.82, 14, 7], ['franka', 'fr3', 0.855, 3, 7], ['staubli', 'tx2_60', 0.67, 4.5], ['epson', 'scara_t3', 0.4, 3, 4], ['yaskawa', 'gp7', 0.927, 7], ['denso', 'vs_060', 0.605, 4]];
  const catalogue = makers.map(([maker, model, reach, payload, axes = 6]) => ({ id: `${maker}/${model}`, maker: maker.replace('_', ' '), model, title: `${maker.replace('_', ' ')} ${model}`.toUpperCase(), axes, reach, payload, mass: payload * 4, picture: `/api/catalogue/${maker}/${model}.svg` }));
  const requests = {
    'language.words': () => ({ words: keywords.map((name) => ({ name, role: /^end/.test(name) ? 'closer' : /else|elif|on/.test(name) ? 'branch' : 'statement', form: `${name} …`, meaning: `What ${name} does.`, in_tests: false }))
      .concat(['speed', 'blend', 'tool', 'exact', 'until', 'timeout'].map((name) => ({ name, role: 'clause', form: name, meaning: '', in_tests: false }))), functions: [{ name: 'offset', signature: 'offset(p, x, y, z, rx, ry, rz)', meaning: 'p shifted along the axes of its frame', in_tests: false }] }),
    files: () => ({ main: 'PAPscript.script', files: [...files].map(([name, f]) => ({ name, kind: name === 'plc.script' ? 'plc' : name === 'cell.yaml' ? 'cell' : name === 'signals.yaml' ? 'signals' : kinds[name.split('.').pop()] ?? 'text', bytes: f.text.length, modified_s: f.modified_s, hash: hash(f.text), running: name === 'PAPscript.script' && cell.running, draft: f.draft !== null })) }),
    'files.read': (r) => { const f = fileOf(r.name); return { name: r.name, text: f.text, hash: hash(f.text), running: false, draft: f.draft }; },
    'files.draft': (r, c) => { if (!files.has(r.name) && r.text !== undefined) files.set(r.name, { text: '', modified_s: Date.now() / 1000, versions: [], draft: null, fresh: true }); const f = files.get(r.name); if (f) f.draft = r.text === undefined ? null : { text: r.text, base: r.base, saved_s: Date.now() / 1000, by: r.by ?? c.name }; return { saved_s: Date.now() / 1000 }; },
    'files.write': (r) => {
      const old = files.get(r.name);
      if (old && !old.fresh && hash(old.text) !== r.base && !r.force) refuse('changed-meanwhile', `'${r.name}' has changed since it was read`);
      files.set(r.name, { text: r.text, modified_s: Date.now() / 1000, draft: null, versions: old && !old.fresh ? [{ number: old.versions.length + 1, when: new Date().toISOString().slice(0, 19).replace('T', ' '), what: 'saved', text: old.text }, ...old.versions] : [] });
      return { name: r.name, hash: hash(r.text) };
    },
    'files.versions': (r) => ({ versions: fileOf(r.name).versions.map(({ text, ...rest }) => ({ ...rest, bytes: text.length })) }),
    'files.version': (r) => ({ text: fileOf(r.name).versions.find((v) => v.number === r.number).text }),
    'files.delete': (r) => (files.delete(r.name), {}),
    'files.rename': (r) => { files.set(r.to, fileOf(r.name)); files.delete(r.name); return {}; },
    'program.check': (r) => ({ problems: check(r.text) }),
    'program.names': () => ({ version: 1, names: [...values.values()].map((v) => ({ name: v.name, kind: v.kind, text: v.text })).concat([...tags.values()].filter((t) => !values.has(t.name)).map((t) => ({ name: t.name, kind: t.tag ? 'tag' : t.type, text: t.text }))).concat([{ name: 'arm', kind: 'robot', text: '' }]) }),
    'program.dry': (r, c, id) => {
      let moves = 0;
      const lines = r.text.split('\n');
      const steps = lines.map((line, i) => [i + 1, /^\s*(move\w+)\s+(\w+)/.exec(line)]).filter(([, m]) => m);
      const timer = setInterval(() => {
        const next = steps[moves++];
        if (next) return c.socket.send(JSON.stringify({ id, ok: true, more: true, result: { line: next[0], moves } }));
        clearInterval(timer);
        c.answer(id, { problems: [{ severity: 'error', code: 'unreachable', what: "'Far' cannot be reached: 0.12 m too far", advice: 'the nearest that can: 0.38 m', file: '', line: 13, column: 1 }], moves: steps.length, reached: null, seconds: 13.7, paths: steps.map(([line, m], i) => ({ robot: 'arm', line, points: [values.get(steps[i - 1]?.[1][2])?.world?.p ?? [0.27, 0, 0.22], values.get(m[2])?.world?.p ?? [0.3, 0, 0.2]] })) });
      }, 60);
      return undefined;
    },
    'program.from': (r) => {
      cell.line = r.line; cell.file = r.program; cell.running = true; cell.paused = !r.confirmed; cell.began = cell.passBegan = cell.time; cell.passes = 0;
      return { where: { file: r.program, line: r.line }, source: fileOf(r.program).text.split('\n')[r.line - 1] ?? '', robot: 'arm', tool: 'suction_cup', frame: '', last_point: 'PrePick', sets: [{ name: 'ActivateGripper', value: 'True' }], reads: [{ name: 'GripperActive', value: 'False' }], variables: [{ name: 'n', value: '2' }], held: [] };
    },
    'program.break': (r) => {
      const places = (list) => (list ?? []).map((each) => ({ file: each.split(':')[0], line: Number(each.split(':')[1]) }));
      const off = places(r.off).map((each) => each.line);
      cell.breakpoints = [...(cell.breakpoints ?? []).filter((each) => !off.includes(each.line)), ...places(r.at)];
      tellProgram();
      return { breakpoints: cell.breakpoints };
    },
    'program.edited': (r) => {
      if (r.lines) cell.breakpoints = r.lines.map((line) => ({ file: r.name, line }));
      tellProgram();
      return { breakpoints: cell.breakpoints ?? [] };
    },
    program: () => programNow(),
    points: () => ({ file: 'PAPpoints.points', files: ['PAPpoints.points', 'cycledata.data'], values: [...values.values()] }),
    'points.teach': (r) => {
      if (values.has(r.name) && !r.replace) refuse('exists', `there is a '${r.name}' already`, 'touch it up, or take another name');
      keep(`${r.replace ? 'touched up' : 'taught'} ${r.name}`);
      const old = values.get(r.name);
      const at = here();
      point(r.name, at.tcp.p, { group: r.group ?? old?.group ?? '' });
      Object.assign(values.get(r.name), r.kind === 'joints' ? { kind: 'joints', pose: null, world: null, joints: at.joints } : { pose: at.tcp, world: at.tcp, taught: { frame: r.frame ?? '', tool: 'suction_cup', robot: 'universal_robots/ur3' } });
      return changed(), values.get(r.name);
    },
    'points.set': (r) => { keep(`changed ${r.name}`); const v = values.get(r.name); if (!v.pose) Object.assign(v, { text: String(r.value), value: r.value }); return changed(), v; },
    'points.rename': (r) => { keep(`renamed ${r.name}`); values.set(r.to, { ...values.get(r.name), name: r.to }); values.delete(r.name); changed(); return { uses: [...files].flatMap(([file, f]) => f.text.split('\n').flatMap((line, i) => (new RegExp(`\\b${r.name}\\b`).test(line) && file.endsWith('.script') ? [{ file, line: i + 1 }] : []))) }; },
    'points.shift': (r) => { keep(`shifted ${r.names.join(', ')}`); for (const name of r.names) { const v = values.get(name); const p = v.pose.p.map((x, i) => x + r.by['xyz'[i]]); v.pose = { ...v.pose, p }; v.world = v.pose; } changed(); return {}; },
    'points.group': (r) => { for (const name of r.names) values.get(name).group = r.group; changed(); return {}; },
    'points.delete': (r) => { keep(`deleted ${r.name}`); values.delete(r.name); changed(); return {}; },
    'points.undo': () => { const last = undone.pop() ?? refuse('nothing', 'there is nothing to undo'); values.clear(); for (const [k, v] of last.values) values.set(k, v); changed(); return { what: last.what }; },
    'points.here': here,
    'points.frame': (r) => { const d = (a, b) => Math.hypot(...a.map((x, i) => x - b[i])); if (d(r.origin, r.on_x) < 0.001) refuse('bad-points', 'origin and the place on x are less than 1 mm apart'); const pose = { p: r.origin, q: [0, 0, 0, 1] }; if (!r.dry) { keep(`frame ${r.name}`); point(r.name, r.origin, { pose, world: pose }); changed(); } return { pose, angle: 1.52, x_length: d(r.origin, r.on_x), y_length: d(r.origin, r.in_plane) }; },
    'points.tool': (r) => { if (!r.dry) { keep(`tool ${r.name}`); point(r.name, [0, 0, 0.1]); changed(); } return { tcp: [0, 0.001, 0.098], tip: [0.3, 0.1, 0.02], residuals: r.poses.map((_, i) => 0.0002 + 0.0001 * i), rms: 0.0004, largest: 0.0007 }; },
    'tags.list': (r) => ({ tags: [...tags.values()].filter((t) => (r.names?.length ? r.names.includes(t.name) : t.tag)), links: [{ name: 'plc', address: 'modbus 127.0.0.1:502', up: true, reason: '', losses: 1, exchanges: 1234, round_ms: 3.2, on_loss: 'hold', tags: 6 }, { name: 'broker', address: 'mqtt 127.0.0.1:1883', up: false, reason: 'no answer for 0.5 s; it is tried again', losses: 4, exchanges: 99, round_ms: 12.5, on_loss: 'go_on', tags: 2 }] }),
    'tags.set': (r, c) => put(r.name, r.value, c.name),
    'tags.force': (r, c, id) => { const each = put(r.name, r.value, 'forced'); each.forced = true; tellTag(each); c.forces = { ...c.forces, [id]: each }; c.socket.send(JSON.stringify({ id, ok: true, more: true, result: each })); return undefined; },
    'session.end': (r, c) => { const each = c.forces?.[r.of]; if (each) { each.forced = false; each.changed_by = 'released'; tellTag(each); } return {}; },
    health: () => ({ state: cell.state, cause: '', standing: true, time_s: cell.time, rate_hz: 500, cycles: Math.round(cell.time * 500), late: 3, cost: histogram(22, 1.5), wake_up: histogram(8, 2), period: histogram(2000, 4), clamps: 12,
      parts: [{ component: 'arm', rate_hz: 500, turns: 180000, cost: { p50: 9, p99: 14, max: 60 } }, { controller: 'arm_motion', rate_hz: 500, turns: 180000, cost: { p50: 6, p99: 9, max: 31 } }], threads: [{ component: 'gripper', rate_hz: 100, own_clock: true, runs: 3600, late: 2, missed: 3, cost: { p50: 80, p99: 300, max: 900 }, wake_up: {}, period: {} }], fallen: [] }),
    limits: () => [{ interface: 'arm/elbow_joint/position', limit: 'velocity', count: 12, asked: 1.62, given: 1.57, time_s: cell.time - 20 }],
    'hardware.list': () => hardware, 'control.list': () => controllers,
    'hardware.state': (r) => (Object.assign(named(hardware, r.name), { state: r.state, being: r.state }), { name: r.name, state: r.state, stopped: [] }),
    'hardware.recover': (r) => ({ name: r.name, state: 'active', fallen: [], next: '' }),
    'control.switch': (r) => { if (!r.dry) { for (const n of r.activate ?? []) named(controllers, n).state = 'active'; for (const n of r.deactivate ?? []) named(controllers, n).state = 'inactive'; } return { ok: true, reason: '', start: r.activate ?? [], stop: r.deactivate ?? [] }; },
    cells: () => ({ open: '/cells/pick_and_place', cells: [{ name: 'pick_and_place', folder: '/cells/pick_and_place', title: 'Pick and place', robots: ['universal_robots/ur3'], recent: true }, { name: 'sorting', folder: '/cells/sorting', title: 'Sorting by colour', robots: ['universal_robots/ur5e'], recent: false }, { name: 'bin_picking', folder: '/cells/bin_picking', title: 'Bin picking', robots: ['franka/fr3'], recent: false }] }),
    'cell.open': () => ({}), 'cell.change': () => ({}), 'cell.keep': () => ({}), 'cell.connect': () => ({}), 'cell.reset': () => ({}), 'cell.save_as': (r) => ({ folder: `/cells/${r.name}` }), 'cell.new': (r) => ({ folder: `/cells/${r.name}` }),
    'cell.check': () => ({ problems: [] }),
  };
  const programNow = () => {
    const file = cell.file ?? 'PAPscript.script';
    const source = files.get(file)?.text.split('\n')[cell.line - 1]?.trim() ?? '';
    return { file, state: cell.running ? 'running' : 'finished', paused: cell.paused, where: { file, line: cell.line }, source, passes: cell.passes, breakpoints: cell.breakpoints ?? [], control: 'program', held: [],
      tasks: [{ name: 'program', state: cell.running ? 'waiting' : 'finished', where: { file, line: cell.line }, source, waits_for: 'move', names: [], text: '', passes: cell.passes, paused: cell.paused, calls: [], variables: [{ name: 'n', value: String(cell.passes) }, { name: 'slot', value: 'xyz(0.3, 0.1, 0.04) rpy(3.14, 0, 0)' }], robot: 'arm', tool: 'suction_cup', frame: '' }] };
  };
  let last = '';
  const tellProgram = () => { const text = JSON.stringify(programNow()); if (text !== last) tell({ event: 'program', ...JSON.parse((last = text)) }); };
  setInterval(tellProgram, 150);
  setInterval(() => { put('Cycle', cell.passes, 'program'); put('Temperature', Math.round(400 + 20 * Math.sin(cell.time)) / 10, 'link plc'); }, 1000);
  return { requests, moves: ['files.write', 'files.delete', 'files.rename', 'program.from', 'points.teach', 'points.set', 'points.rename', 'points.shift', 'points.group', 'points.delete', 'points.undo', 'tags.set', 'tags.force', 'control.switch', 'hardware.state', 'hardware.recover', 'cell.open', 'cell.change', 'cell.connect', 'cell.reset'],
    json: { '/api/catalogue': catalogue },
    picture: (path) => (path.endsWith('.svg') ? `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 200 200"><g fill="none" stroke="#4a7fc1" stroke-width="14" stroke-linecap="round" stroke-linejoin="round"><path d="M60 180V120L90 50L150 70L165 110"/></g><rect x="35" y="176" width="50" height="14" fill="#888"/></svg>` : null) };
}
