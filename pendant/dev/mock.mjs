// A cell that is none, for work on the page: serves dist/ and speaks the pendant's wire. npm run mock [-- PORT]
import { createReadStream, existsSync } from 'node:fs';
import { createServer } from 'node:http';
import { extname, join, normalize } from 'node:path';
import { fileURLToPath } from 'node:url';
import { WebSocketServer } from 'ws';
import { pageRequests } from './mock-pages.mjs';
import { axisAngle, forward, joints, tcp, turn, velocities } from './kinematics.mjs';

const port = Number(process.argv[2] ?? 8765);
const dist = fileURLToPath(new URL('../dist', import.meta.url));
const identity = [0, 0, 0, 1];
const origin = { p: [0, 0, 0], q: identity };

const kWall = 0.45;  // y of what is scanned

// The cell ------------------------------------------------------------------------------------------------
const home = [0, -1.4, 1.6, 1.37, 0, 0];
const cell = {
  q: [...home], dq: joints.map(() => 0), time: 0, state: 'running', cause: '', profile: 'reduced', override: 100,
  jog: null, goal: null, running: false, paused: false, line: 2, passes: 0, began: 0, passBegan: 0, cycle: null, held: false,
  part: { p: [0.3, 0.15, 0.02], q: identity, held: false },
};
const cube = { shape: 'box', size: [0.04, 0.04, 0.04], origin, color: [0.95, 0.6, 0.15, 1] };
const rod = (from, to, radius, color) => {
  const d = to.map((v, i) => v - from[i]);
  const length = Math.hypot(...d);
  const angle = Math.acos(d[2] / length);
  const axis = Math.hypot(d[0], d[1]) < 1e-6 ? [1, 0, 0] : [-d[1] / Math.hypot(d[0], d[1]), d[0] / Math.hypot(d[0], d[1]), 0];
  return { shape: 'capsule', radius, length, origin: { p: from.map((v, i) => (v + to[i]) / 2), q: axisAngle(axis, angle) }, color };
};
const grey = [0.75, 0.78, 0.82, 1], blue = [0.25, 0.5, 0.78, 1];
const model = {
  root: 'base',
  links: [
    { name: 'base', visuals: [{ shape: 'cylinder', radius: 0.065, length: 0.1, origin: { p: [0, 0, 0.05], q: identity }, color: grey }] },
    ...joints.map((joint, i) => ({ name: joint.child, visuals: [rod([0, 0, 0], joints[i + 1]?.p ?? [0, 0.05, 0], [0.055, 0.045, 0.04, 0.035, 0.035, 0.03][i], i % 2 ? grey : blue)] })),
  ],
  joints: joints.map((j) => ({ name: j.name, interface: `arm/${j.name}`, type: 'revolute', parent: j.parent, child: j.child, origin: { p: j.p, q: identity }, axis: j.axis, mimic: null })),
  tcp,
  tool: { name: 'suction_cup', visuals: [rod([0, 0, -0.06], [0, 0, -0.005], 0.012, [0.2, 0.22, 0.25, 1])] },
};
const box = (name, size, p, color) => ({ name, pose: { p, q: identity }, visuals: [{ shape: 'box', size, origin, color }] });
/** A scanned wall, as the boxes of a point cloud. */
function scan() {
  const boxes = [];
  for (let x = -0.4; x < 0.7; x += 0.05)
    for (let z = 0.05; z < 0.7; z += 0.05) boxes.push(x, kWall + 0.015 * Math.sin(9 * x + 7 * z), z, 0.05, 0.03, 0.05);
  return { name: 'scan', pose: { p: [0, 0, 0], q: identity }, visuals: [{ shape: 'boxes', boxes, origin, color: [0.62, 0.65, 0.7, 1] }] };
}
const scene = {
  floor: -0.75,
  fixtures: [box('table', [1.4, 1.4, 0.04], [0.2, 0, -0.02], [0.55, 0.58, 0.62, 1]), scan()],
  parts: [{ name: 'cube1', kind: 'cube', pose: origin, visuals: [cube] }],
  bins: [{ name: 'tray', lower: [0.21, -0.22, 0], upper: [0.39, -0.08, 0.08], color: [0.25, 0.55, 0.35, 0.25] }],
  movers: [],
};
const info = {
  name: 'pick_and_place', folder: '/cells/pick_and_place', simulated: true, real: false, rate_hz: 500,
  robots: [{ name: 'arm', id: 'mock/six', title: 'Mock Six', base: origin, model: '/api/model/arm',
    joints: joints.map((j) => ({ name: j.name, interface: `arm/${j.name}`, type: 'revolute', lower: -j.limit, upper: j.limit, velocity: j.velocity, unit: 'rad' })) }],
  cameras: [], scene: '/api/scene',
  frames: [['Pick', 0.15], ['Place', -0.15]].map(([name, y]) => ({ name, in: '', pose: { p: [0.3, y, 0.04], q: [1, 0, 0, 0] } })),
};
const fields = [
  ...joints.flatMap((j) => [['position', 'rad'], ['velocity', 'rad/s'], ['effort', 'N m']].map(([f, unit]) => ({ name: `arm/${j.name}/${f}`, unit }))),
  ...joints.map((j) => ({ name: `arm/${j.name}/command_position`, unit: 'rad' })),
  ...['x', 'y', 'z'].map((f) => ({ name: `arm/tcp/${f}`, unit: 'm' })),
  ...['qx', 'qy', 'qz', 'qw'].map((f) => ({ name: `arm/tcp/${f}`, unit: '' })),
  { name: 'arm/tcp/speed', unit: 'm/s' }, { name: 'arm/singularity', unit: '' },
  { name: 'loop/period_us', unit: 'us' }, { name: 'loop/late', unit: '' }, { name: 'loop/cost_us', unit: 'us' },
];
let singularity = 0;
const keyframes = [home, [0.5, -1.1, 1.7, 0.97, 0, 0], [0.5, -0.9, 1.75, 0.72, 0, 0], [0.5, -1.1, 1.7, 0.97, 0, 0], [-0.5, -1.1, 1.7, 0.97, 0, 0], [-0.5, -0.9, 1.75, 0.72, 0, 0]];
let frame = 0;

function wantedVelocity() {
  const jog = cell.jog;
  const toward = (goal, share) => {
    const d = goal.map((g, i) => g - cell.q[i]);
    const far = Math.max(...d.map(Math.abs));
    return far < 1e-3 ? null : d.map((x) => (x / far) * Math.min(share, 4 * far));
  };
  if (jog) {
    if (performance.now() - jog.beat > 120) return end('lost'), joints.map(() => 0);
    if (jog.goal) return toward(jog.goal, 0.5 * jog.speed) ?? (end('arrived'), joints.map(() => 0));
    if (jog.mode === 'joint') return joints.map((j, i) => (jog.axis[i] ?? 0) * j.velocity * 0.1 * jog.speed);
    let v = jog.axis.slice(0, 3).map((x) => x * 0.25 * jog.speed), w = jog.axis.slice(3).map((x) => x * 0.6 * jog.speed);
    if (jog.frame === 'tool') [v, w] = [turn(forward(cell.q).q, v), turn(forward(cell.q).q, w)];
    return velocities(cell.q, [...v, ...w]).dq;
  }
  if (cell.running && cell.state === 'running' && !cell.paused) {
    const go = toward(keyframes[frame], (0.9 * cell.override) / 100);
    if (go) return go;
    frame = (frame + 1) % keyframes.length;
    cell.line = 2 + frame * 3;
    if (frame === 3) cell.part.held = true;
    if (frame === 0) {
      cell.part.held = false;
      cell.cycle = cell.time - cell.passBegan;
      cell.passBegan = cell.time;
      cell.passes++;
    }
  }
  return joints.map(() => 0);
}
function end(why) {
  const jog = cell.jog;
  cell.jog = null;
  jog?.client.event({ event: 'jog', robot: 'arm', jog: jog.number, over: true, why, text: '' });
  if (jog?.step) jog.client.answer(jog.step, { done: true });
}
setInterval(() => {
  const dt = 0.01;
  const wanted = wantedVelocity();
  cell.time += dt;
  cell.dq = cell.dq.map((v, i) => v + Math.max(-0.08, Math.min(0.08, wanted[i] - v)));
  cell.q = cell.q.map((q, i) => Math.max(-joints[i].limit, Math.min(joints[i].limit, q + cell.dq[i] * dt)));
  singularity = velocities(cell.q, [0, 0, 0, 0, 0, 0]).singularity;
  if (cell.state === 'stopping' && cell.dq.every((v) => Math.abs(v) < 1e-3)) cell.state = 'held';
  const now = forward(cell.q);
  if (cell.part.held) cell.part.p = now.p.map((v, i) => v + turn(now.q, [0, 0, 0.022])[i]);
}, 10);

// Clients -------------------------------------------------------------------------------------------------
const clients = new Set();
let holder = null, asking = null, numbers = 1;
const who = (client) => client && { client: client.number, name: client.name };
const stateOf = () => ({
  event: 'status', state: cell.state, cause: cell.cause, standing: cell.dq.every((v) => Math.abs(v) < 1e-3), armed: true, simulated: true,
  profile: cell.profile, override: cell.override, allowed: 100, holder: who(holder), clients: clients.size, alarms: 0,
  program: { file: 'PAPscript.script', name: 'PAPscript.script', state: cell.running ? 'running' : 'finished', paused: cell.paused, ended: !cell.running, where: { file: 'PAPscript.script', line: cell.line }, passes: cell.passes,
    source: `moveto ${['p0', 'PrePick', 'Pick', 'Pass1', 'Pass2', 'Place'][frame]}`, problem: null },
  bases: { arm: origin }, jogged: cell.jog ? ['arm'] : [],
});
const give = (client, what) => {
  const before = holder;
  holder = client;
  if (before && before !== client) before.event({ event: 'control', what: 'lost', name: client?.name ?? '', you_hold: false });
  client?.event({ event: 'control', what, name: before?.name ?? '', you_hold: true });
};
const refuse = (code, what) => { throw Object.assign(new Error(what), { code }); };
const partsNow = () => ({ event: 'parts', full: true, parts: [{ name: 'cube1', p: cell.part.p, q: cell.part.q, in_world: true, held_by: cell.part.held ? 'arm' : null }] });
const stopNow = () => { if (cell.jog) end('stopped'); cell.state = 'stopping'; cell.cause = 'a stop was asked for'; return { asked: true }; };
const beginJog = (client, request, extra) => {
  if (cell.running && cell.state === 'running' && !cell.paused) refuse('program-runs', 'a program runs: hold it first');
  cell.jog = { number: numbers++, client, beat: performance.now(), speed: request.speed ?? 1, mode: request.mode, frame: request.frame, ...extra };
  return cell.jog.number;
};
const axisOf = (r) => Array.isArray(r.axis) ? r.axis : Array.from({ length: r.mode === 'joint' ? joints.length : 6 }, (_, i) => (i === r.axis ? (r.direction ?? 1) : 0));
const moves = new Set(['control.resume', 'control.recover', 'control.discard', 'control.override', 'profile', 'jog.begin', 'jog.step', 'jog.goto', 'program.go', 'program.step', 'program.from']);
const requests = {
  'session.hello': (r, c) => { c.name = r.name; return { client: c.number, holder: who(holder), you_hold: holder === c, version: 'mock', role: 'administer', token_ok: true, local: true }; },
  'session.watch': (r, c) => {
    c.event({ event: 'layout', id: 1, fields });
    c.event(partsNow());
    const tag = (value) => ({ value, text: String(value), quality: 'good', forced: false, by: '', since: null });
    c.event({ event: 'tags', full: true, values: { Vacuum: tag(false), FeederLeft: tag(3) } });
    c.rate = r.rate;
    return {};
  },
  'session.take': (r, c) => {
    if (!holder || holder === c || r.force) return give(c, 'taken'), { you_hold: true };
    asking = { client: c, timer: setTimeout(() => give(c, 'given'), 10_000) };
    holder.event({ event: 'asked', client: c.number, name: c.name, seconds: 10 });
    return { you_hold: false, seconds: 10 };
  },
  'session.release': (_, c) => (holder === c && give(null, 'given'), {}),
  'session.answer': (r) => { clearTimeout(asking?.timer); if (r.give) give(asking.client, 'given'); else asking?.client.event({ event: 'control', what: 'refused', you_hold: false }); return {}; },
  'control.stop': stopNow, 'control.hold': stopNow,
  'control.resume': () => { cell.state = 'running'; cell.cause = ''; return { asked: true }; },
  'control.recover': () => { cell.state = 'held'; return { asked: true }; },
  'control.discard': () => { cell.running = false; cell.state = 'running'; return { asked: true }; },
  'control.override': (r) => { cell.override = r.percent; return { percent: r.percent }; },
  profile: (r) => { cell.profile = r.name; return { profile: r.name }; },
  'jog.begin': (r, c) => ({ jog: beginJog(c, r, { axis: axisOf(r) }) }),
  'jog.beat': (r) => { if (cell.jog?.number === r.jog) { cell.jog.beat = performance.now(); if (r.speed) cell.jog.speed = r.speed; if (r.axis) cell.jog.axis = r.axis; } },
  'jog.end': () => (cell.jog && end('released'), {}),
  'jog.step': (r, c, id) => {
    const goal = [...cell.q];
    if (r.mode === 'joint') goal[r.axis] += r.amount;
    else {
      const twist = [0, 0, 0, 0, 0, 0];
      twist[r.axis] = r.amount / 100;
      for (let i = 0; i < 100; ++i) velocities(goal, twist).dq.forEach((v, k) => (goal[k] += v));
    }
    beginJog(c, r, { goal, step: id, beat: performance.now() + 3e4 });
    return undefined;
  },
  'jog.goto': (r, c) => {
    const goal = joints.map((j, i) => r.joints?.[j.name] ?? home[i]);
    const path = Array.from({ length: 40 }, (_, k) => forward(cell.q.map((q, i) => q + ((goal[i] - q) * k) / 39)).p);
    if (r.dry) return { ok: true, reason: '', path, seconds: 2.4 };
    return { jog: beginJog(c, r, { goal }) };
  },
  'program.from': () => { cell.running = true; cell.paused = false; cell.began = cell.passBegan = cell.time; cell.passes = 0; return {}; },
  'program.stop': () => { cell.running = false; return {}; },
  'program.pause': () => { cell.paused = true; return {}; },
  'program.go': () => { cell.paused = false; return {}; },
  'program.step': () => { cell.line++; return {}; },
  health: () => ({ state: cell.state, time_s: cell.time }),
};

const pages = pageRequests({ cell, tell: (event) => clients.forEach((client) => client.event(event)) });
Object.assign(requests, pages.requests);
pages.moves.forEach((name) => moves.add(name));

const http = createServer((request, response) => {
  const path = new URL(request.url, 'http://x').pathname;
  const json = { '/api/cell': info, '/api/model/arm': model, '/api/scene': scene, '/api/requests': [], ...pages.json }[path];
  if (json) return response.writeHead(200, { 'Content-Type': 'application/json' }).end(JSON.stringify(json));
  const picture = path.startsWith('/api/catalogue/') && pages.picture(path);
  if (picture) return response.writeHead(200, { 'Content-Type': 'image/svg+xml' }).end(picture);
  const file = join(dist, normalize(path === '/' ? '/index.html' : path));
  if (!file.startsWith(dist) || !existsSync(file)) return response.writeHead(404).end('not here');
  const types = { '.html': 'text/html', '.js': 'text/javascript', '.css': 'text/css', '.svg': 'image/svg+xml' };
  response.writeHead(200, { 'Content-Type': types[extname(file)] ?? 'application/octet-stream',
    'Content-Security-Policy': "default-src 'self'; img-src 'self' data: blob:; style-src 'self' 'unsafe-inline'" });
  createReadStream(file).pipe(response);
});
new WebSocketServer({ server: http, path: '/ws' }).on('connection', (socket) => {
  const client = {
    number: numbers++, name: '', rate: 0, last: '', socket,
    event: (e) => socket.send(JSON.stringify(e)),
    answer: (id, result) => id !== undefined && socket.send(JSON.stringify({ id, ok: true, result })),
  };
  clients.add(client);
  socket.on('close', () => { clients.delete(client); if (holder === client) holder = null; if (cell.jog?.client === client) end('lost'); });
  socket.on('message', (text) => {
    const request = JSON.parse(text);
    try {
      if (!requests[request.request]) refuse('unknown-request', `there is no request '${request.request}'`);
      if (moves.has(request.request) && holder !== client) refuse('no-control', 'another client has control');
      const result = requests[request.request](request, client, request.id);
      if (result !== undefined) client.answer(request.id, result);
    } catch (error) {
      socket.send(JSON.stringify({ id: request.id, ok: false, error: { code: error.code ?? 'internal', what: error.message, advice: error.advice ?? '' } }));
    }
  });
});
/** What is nearest to the tool, and the distances along the way to the next place. */
setInterval(() => {
  const { p } = forward(cell.q);
  const distance = kWall - 0.03 - p[1];
  const moves = cell.jog || (cell.running && !cell.paused);
  const near = { a: 'arm/tool', b: 'fixture scan', distance, kept: 0.005, on_a: p, on_b: [p[0], kWall - 0.03, p[2]], pace: cell.jog ? 1 : Math.min(1, distance / 0.3) };
  const path = Array.from({ length: 40 }, (_, k) => forward(cell.q.map((q, i) => q + ((keyframes[frame][i] - q) * k) / 39)).p);
  const plan = { path, clear: path.map((at) => Math.min(0.15, kWall - 0.13 - at[1])), target: { joints: keyframes[frame] } };
  for (const client of clients) {
    client.event({ event: 'near', robots: moves && distance < 0.3 ? { arm: near } : {} });
    client.event({ event: 'plan', plans: cell.running && !cell.paused ? { arm: plan } : {} });
  }
}, 200);

let sequence = 0;
setInterval(() => {
  const now = forward(cell.q);
  const v = velocities(cell.q, [0, 0, 0, 0, 0, 0]) && Math.hypot(...cell.dq) * 0.3;
  const values = [...cell.q.flatMap((q, i) => [q, cell.dq[i], Math.sin(q) * 8]), ...cell.q, ...now.p, ...now.q, v, singularity, 2000, 0, 21 + 3 * Math.random()];
  const buffer = Buffer.alloc(16 + 4 * values.length);
  buffer.writeUInt8(1, 0); buffer.writeUInt16LE(1, 2); buffer.writeUInt32LE(++sequence, 4); buffer.writeDoubleLE(cell.time, 8);
  values.forEach((x, i) => buffer.writeFloatLE(x, 16 + 4 * i));
  for (const client of clients) {
    if (client.rate) client.socket.send(buffer);
    const text = JSON.stringify(stateOf());
    if (text !== client.last && client.rate) client.socket.send((client.last = text));
    if (cell.part.held) client.event(partsNow());
  }
}, 33);
http.listen(port, '127.0.0.1', () => console.log(`http://127.0.0.1:${http.address().port}/`));
