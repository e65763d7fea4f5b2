// What the cell says for terminals, as the page says it: by code and values.
import { beforeEach, describe, expect, it, vi } from 'vitest';
import supervisor from '../../polyarm/control/supervisor.cpp?raw';

vi.stubGlobal('navigator', { language: 'en', userAgent: '' });
const {causeWords, findingWords, forwardRobots, kSaysAll, lineWords, noteWords, ownWords, plain, problemWords, tablesLoaded} = await import('../src/i18n/told');
const { kDeviceRows } = await import('../src/i18n/device');
const { settings } = await import('../src/state/settings');
const { languageLoaded } = await import('../src/i18n');
settings.language.value = 'es';
await languageLoaded();
const {en} = await import('../src/i18n/en');
const {es} = await import('../src/i18n/es');
const {codes} = await import('../src/i18n/en/codes');
const sources =
    import.meta.glob(
        '../../{polyarm/{io,setup,machine,tasks,operation,inside,requests,cell,protocol,access,server,meshes,moves,jog,teleop,paths,timing,kinematics,ik,control,controllers,hardware,data,signals,trajectory,language,program,vm,joint_control,wheels,broadcasters,plugins},links/*,apps}/*.cpp',
        {query: '?raw', import: 'default', eager: true}) as Record<string, string>;

/** Where a problem's code stands in the sources. */
const kProblem =
    /(?:\bProblem\s*\{|\bProblem \w+\s*\{|\bError\(|\.(?:error|warning)\(|(?:on_problem|hold_for)\([^"{]{0,60}\{|\b(?:unchecked|return no|return tell)\()\s*"([a-z][a-z0-9]*(?:-[a-z0-9]+)*)"/g;
/** Only at a terminal, or while files of a cell are read: their own words name file, line and value. */
const kOfFiles =
    /\/(?:cell_file|cell_reach|compare|launch_cell|controllers_plan|parser|lexer|statement_parser|expression_parser|checker\w*|check\w*)\.cpp$/;
const sentAs = new Map<string, string>();
for (const [file, text] of Object.entries(sources))
  if (!kOfFiles.test(file) && !file.includes('/apps/'))
    for (const [, code] of text.matchAll(kProblem)) sentAs.set(code!, file);

const inBoth = (say: () => string) => ['en', 'es'].map(
    (language) => ((settings.language.value = language as 'en' | 'es'), say()));

beforeEach(() => {
  settings.language.value = 'en';
  forwardRobots.value = {names: [], all: false};
});

describe('what drivers tell', () => {
  const drivers = Object.values(import.meta.glob('../../drivers/{ur,fanuc,abb,kuka,yaskawa,xarm,franka,wire}/{words,tcp}.cpp', { query: '?raw', import: 'default', eager: true }) as Record<string, string>);
  /** The texts of each file in one line: sentences are written in pieces, with names between them. */
  const written = drivers.map((text) => [...text.matchAll(/"((?:[^"\\\n]|\\.)*)"/g)].map(([, piece]) => piece).join(''));

  it('has no row that no driver says any more', () => {
    expect(written.length).toBe(9);
    for (const [key, pattern] of kDeviceRows) {
      const free = new RegExp(pattern.source.replaceAll('^', '').replaceAll(' .* ', '.{0,80}'));
      expect(written.some((each) => free.test(each)), key).toBe(true);
    }
  });

  it('has a row for each reason for which a driver says that a controller stopped', () => {
    const reasons = written.flatMap((text) => [...text.matchAll(/ (stopped (because|for|at|with) |stopped before an? |did not take )((?! (stopped|did not|has|is) )[a-z ])+/g)].map(([each]) => each));
    expect(reasons.length).toBeGreaterThan(8);
    for (const each of reasons) expect(kDeviceRows.some(([, pattern]) => pattern.test(`the controller at 10.0.0.7${each}`)), each).toBe(true);
  });

  it('names no key of the page: which one comes next depends on the state', () => {
    const keys = (['bar.recover', 'state.activate', 'bar.resume'] as const).flatMap((key) => [en[key], es[key]]);
    for (const table of [en, es])
      for (const [key, text] of Object.entries(table))
        if (key.startsWith('device.')) expect(text, key).not.toMatch(new RegExp(`(press|pulse) (${keys.join('|')})`, 'i'));
  });

  it('is said in Spanish, with the address and the number', () => {
    const stop = 'the controller at 10.0.0.7 made a protective stop: look what the arm touched (it says: C153A0)';
    const fault = (reason: string) => problemWords({ code: 'fault', what: '', facts: { cause: 'component', component: 'arm', reason } }).detail;
    expect(fault(stop)).toBe(stop);
    settings.language.value = 'es';
    expect(fault(stop)).toMatch(/^El controlador en 10\.0\.0\.7 hizo una parada de protección/);
    expect(fault('the controller at 10.0.0.7 stopped for a collision (C31): currents; then recover here')).toMatch(/\(C31\)$/);
    expect(fault('the fence of the controller at 10.0.0.7 is open: close it')).toMatch(/protección del controlador en 10/);
    expect(fault('the controller at 10.0.0.9: somebody pressed the user stop; release it; then recover here')).toMatch(/^El controlador en 10\.0\.0\.9 está en parada de emergencia/);
    expect(fault('the controller at 10.0.0.9 closed the connection at once: activate FCI in Desk, end other programs that use the robot')).toMatch(/^Otro programa usa el controlador en 10/);
    expect(fault('the controller at 10.0.0.9 stopped because commands were not smooth (joint_motion_generator_acceleration_discontinuity): lower the jerks')).toMatch(/^El controlador en 10\.0\.0\.9 se detuvo porque las órdenes/);
    expect(fault('its cable is chewed')).toBe('its cable is chewed');
    const refused = problemWords({ code: 'component-failed', what: `the hardware component 'arm' could not be activated and is inactive: ${stop}` });
    expect(refused.detail).toMatch(/^El controlador en 10\.0\.0\.7 hizo una parada de protección/);
    const open = "the hardware component 'arm' could not be activated and is inactive: the fence of the controller at 10.0.0.7 is open: close it";
    expect(problemWords({ code: 'component-failed', what: open }).detail).toMatch(/^Una protección del controlador en 10/);
  });
});

describe('what the cell tells', () => {
  it('has every cause of a stop in both languages', () => {
    const list = /const char\* code\(StopCause cause\) \{([^}]*\})/.exec(supervisor)?.[1] ?? '';
    const ofLoop =
        [...list.matchAll(/"([^"]+)"/g)].map((found) => found[1]!).filter((cause) => cause !== 'none');
    expect(ofLoop.length).toBeGreaterThan(10);
    // What the cell itself stops for: links, signs of life, programs, a run that failed.
    const own = Object.values(sources).flatMap(
        (text) =>
            [...text.matchAll(
                 /hold_for\(\{"([\w-]+)"|Problem why\{"([\w-]+)"|LifeCycle::stop_cause[^}]*return \{"([\w-]+)"|(?:stopped_ = |return )Problem\{\s*"(link-\w+|heartbeat)"/g)]
                .map((found) => (found[1] ?? found[2] ?? found[3] ?? found[4])!));
    for (const code of ['connected', 'program-hold', 'run-failed', 'link-lost', 'link-stale', 'heartbeat'])
      expect(own).toContain(code);
    const facts = {link: 'plc', tag: 'Alive', time_s: 0.5, reason: 'empty'};
    for (const code of [...ofLoop, ...own]) {
      const [english, spanish] = inBoth(() => causeWords(code, 'its own words', facts));
      expect(english, code).not.toBe('its own words');
      expect(spanish, code).not.toBe('its own words');
      expect(spanish, code).not.toBe(english);
      expect(english + spanish!, code).not.toMatch(/[{}]/);
    }
  });

  it('has a text in every language for every code that a running cell can send', () => {
    expect(sentAs.size).toBeGreaterThan(150);
    const lacks =
        [...sentAs].filter(([code]) => !(`told.${code}` in en)).map(([code, file]) => `${code} (${file})`);
    expect(lacks).toEqual([]);
    for (const key of Object.keys(codes) as (keyof typeof codes)[]) expect(es[key], key).toBeTruthy();
    // What ends a run before there is a cell reaches pages that wait for one.
    for (const [, code] of sources['../../apps/run.cpp']!.matchAll(/const char\* k\w+ = "([a-z]+(?:-[a-z]+)+)"/g)) expect(en, code).toHaveProperty([`told.${code}`]);
  });

  it('has no text for a code that nobody sends', () => {
    const all = Object.values(sources).join('\n');
    const ofPage = ['not-connected', 'no-answer', 'http-401', 'http-403', 'http-404'];
    const unused = Object.keys(codes)
                       .map((key) => key.slice('told.'.length))
                       .filter((code) => !ofPage.includes(code) && !all.includes(`"${code}"`));
    expect(unused).toEqual([]);
  });

  it('fills the values of a problem into its sentence, with units as they are shown', () => {
    const contact = {
      code: 'contact',
      what: 'arm/tool touched fixture table at 1.2 s, 2.10 mm deep',
      facts: {a: 'arm/tool', b: 'fixture table', depth_m: 0.0021, at_s: 1.2, doing: 'program'}
    };
    expect(inBoth(() => problemWords(contact).text)).toEqual([
      'arm/tool touched table, 2.1 mm deep', 'arm/tool tocó table, 2,1 mm de profundidad'
    ]);
    const pushed = {code: 'moved-while-held', what: '…', facts: {joint: 'arm/elbow', moved_rad: 0.1}};
    expect(inBoth(() => problemWords(pushed).text)).toEqual([
      'arm/elbow was moved by 5.7 ° during the hold', 'arm/elbow se movió 5,7 ° mientras estaba retenido'
    ]);
    const fault = {
      code: 'fault',
      what: 'a hardware component failed (R6Bot: no answer)',
      facts: {cause: 'component', component: 'R6Bot', reason: 'no answer'}
    };
    expect(inBoth(() => problemWords(fault).text)).toEqual([
      'A hardware component failed: R6Bot', 'Falló un componente de los equipos: R6Bot'
    ]);
    expect(problemWords(fault).detail).toBe('no answer');
    expect(inBoth(() => problemWords({code: 'fault', what: '', facts: {cause: 'jump'}}).text)[1])
        .toBe('La celda está en fallo: La posición medida de un eje dio un salto');
  });

  it('falls back to the sentence of the code where a value is missing, and to the words of the cell where there is no code',
     () => {
       const lacks = {code: 'moved-while-held', what: 'own words', facts: {joint: 'arm/elbow'}};
       expect(inBoth(() => problemWords(lacks).text)).toEqual([
         'own words', 'Un eje se movió mientras estaba retenido'
       ]);
       expect(inBoth(() => problemWords({code: 'never-heard-of', what: 'own words'}).text)).toEqual([
         'own words', 'own words'
       ]);
       expect(causeWords('never-heard-of', 'own words')).toBe('own words');
       settings.language.value = 'es';
       expect(problemWords({code: 'no-answer', what: 'the cell did not answer in time'}))
           .toEqual({text: 'La celda no respondió a tiempo', detail: '', advice: ''});
     });

  it('says stops and states of the log in the language of the page', () => {
    settings.language.value = 'es';
    const stop = {
      text: 'stopped in 0.3 s …',
      code: 'stop',
      facts: {cause: 'asked', category: 2, time_s: 0.3, robot: 'arm', tcp_m: 0.012}
    };
    expect(lineWords(stop)).toBe('Parado en 0,30 s, TCP de arm tras 12,0 mm: Se pulsó Pausa o Parar');
    expect(lineWords({text: 'held: a contact', code: 'state', facts: {state: 'held', cause: 'contact'}}))
        .toBe('Retenido: Parado tras un contacto');
    expect(lineWords({text: 'running', code: 'state', facts: {state: 'running'}})).toBe('En marcha');
    expect(lineWords({text: 'program: own', code: ''})).toBe('program: own');
  });

  it('says the note of a question in the language of the page', () => {
    expect(inBoth(() => noteWords('Enter alone means 2'))).toEqual(['No text means 2', 'Sin texto vale 2']);
    expect(inBoth(() => noteWords('the answer is a length, such as 0.04m'))[1]).toBe('Esta respuesta no sirve. Escriba, por ejemplo, 0.04m');
    expect(noteWords('another note')).toBe('another note');
    const all = Object.values(sources).join('\n');
    for (const part of ['"Enter alone means ', '"the answer is "', '", such as "']) expect(all, part).toContain(part);
  });

  it('has a word for everything that a task can wait for, and for every state', () => {
    const kinds = [...(/waits_for\(program::WaitKind kind\) \{([^}]*\})/
                           .exec(sources['../../polyarm/operation/program_status.cpp']!)
                           ?.[1] ??
                       '')
                       .matchAll(/"([^"]*)"/g)]
                      .map((found) => found[1]!)
                      .filter(Boolean);
    expect(kinds.length).toBeGreaterThan(8);
    expect(kinds.filter((kind) => !(`wait.${kind}` in en))).toEqual([]);
    const states =
        [...(/name\(RunState state\) \{([^}]*\})/.exec(supervisor)?.[1] ?? '').matchAll(/"([^"]+)"/g)].map(
            (found) => found[1]!);
    expect(states.length).toBe(5);
    for (const state of states) expect(`state.${state}` in en, state).toBe(true);
  });

  it('shows no English below a sentence that says all', () => {
    settings.language.value = 'es';
    for (const code of kSaysAll) {
      const { text, detail } = problemWords({ code, what: 'the move to Pass2 was discarded' });
      expect([text, detail], code).toEqual([es[`told.${code}` as keyof typeof codes], '']);
      expect(lineWords({ text: 'the move to Pass2 was discarded', code }), code).toBe(text);
    }
    const canceled = { code: 'discarded', what: 'the move to Pass2 was discarded', facts: { target: 'Pass2' } };
    expect(inBoth(() => problemWords(canceled).text)).toEqual(['The motion to Pass2 was canceled', 'Se canceló el movimiento a Pass2']);
    expect(problemWords({ code: 'unreachable', what: 'A is 0.2 m too far' }).detail).toBe('A is 0.2 m too far');
  });

  it('never advises to type a command', () => {
    const texts = Object.values(sources).flatMap((text) => [...text.matchAll(/"((?:[^"\\]|\\.)*\bpolyarm (?:control|run|hardware|tags)\b(?:[^"\\]|\\.)*)"/g)].map((found) => found[1]!));
    expect(texts.length).toBeGreaterThan(20);
    for (const text of [...texts, 'let it go back; or discard the motion; or resume with --anyway']) {
      expect(plain(text), text).not.toMatch(/\bpolyarm [a-z]|--[a-z]/);
      expect(problemWords({ code: 'whatever', what: 'It failed', advice: text }).advice, text).not.toMatch(/\bpolyarm [a-z]|--[a-z]/);
    }
  });

  it('keeps what is no command', () => {
    expect(plain('main.script:3: error: no way there (move the point)')).toBe('main.script:3: error: no way there (move the point)');
    expect(plain('it is held (continue: polyarm control resume; or wait)')).toBe('it is held (wait)');
    expect(plain('let it go back; or resume with --anyway')).toBe('let it go back');
    expect(plain('polyarm control arm')).toBe('');
    for (const text of ['the mesh /tmp/polyarm-cells/own/a.stl is not a whole STL (export it again)', 'another polyarm runs this cell: process 12'])
      expect(plain(text)).toBe(text);
  });

  it('says what is not real, though the words for a terminal name an option', () => {
    const problem = { code: 'nothing-real', what: '--real, but nothing of this cell is real: arm (mock)', advice: 'run without --real', facts: { robots: 'arm (mock)' } };
    expect(inBoth(() => problemWords(problem).text)).toEqual(['Nothing of this cell is real: arm (mock)', 'Nada de esta celda es real: arm (mock)']);
    expect(problemWords(problem).advice).not.toMatch(/--/);
  });

  it('says a problem by its code, and what the cell says of it below', () => {
    const problem = { code: 'motion-held', what: "'arm' is not jogged", advice: 'continue: polyarm control resume' };
    expect(problemWords(problem)).toEqual({ text: "'arm' is not jogged", detail: '', advice: 'Press Resume, or Cancel motion' });
    settings.language.value = 'es';
    expect(problemWords(problem)).toEqual({ text: 'Hay un movimiento en pausa a medio camino', detail: '', advice: 'Pulse Reanudar o Cancelar movimiento' });
  });
});

describe('what is said of programs and files', () => {
  /** Without escapes, as sentences are read. */
  const read = (literal: string) => literal.replace(/\\u([0-9a-f]{4})/g, (_, code: string) => String.fromCharCode(parseInt(code, 16))).replace(/\\(.)/g, '$1');
  /** The arguments of a call as text, from its opening bracket on; literals that follow each other in one. */
  function callAt(text: string, from: number): string {
    let depth = 0;
    let inText = false;
    for (let i = from; i < text.length; ++i) {
      const sign = text[i]!;
      if (inText) {
        if (sign === '\\') ++i;
        else if (sign === '"') inText = false;
      } else if (sign === '"') inText = true;
      else if (sign === "'" && text[i + 2] === "'") i += 2;
      else if ('({['.includes(sign)) ++depth;
      else if (')}]'.includes(sign) && --depth === 0) return text.slice(from, i).replace(/"\s+"/g, '');
    }
    return '';
  }
  const ofLanguage = Object.entries(sources).filter(([file]) => /\/(language|program)\//.test(file));

  it('has a Spanish sentence for all that the checker and the language say', async () => {
    const {advices, sentences} = await import('../src/i18n/es/sentences');
    const {adviceOf, sentenceOf} = await import('../src/i18n/es/match');
    const rows = [...sentences, ...advices].map(([english]) => english).join('\n');
    const lacks: string[] = [];
    let seen = 0;
    for (const [file, text] of ofLanguage)
      for (const found of text.matchAll(/\b(?:error|warning|report|fail|refuse|bad|SyntaxError)\s*[({]/g))
        for (const [, literal] of callAt(text, found.index + found[0].length - 1).matchAll(/"((?:[^"\\\n]|\\.)*)"/g)) {
          // Examples of code stay as they are; so do pieces that are too short to be a sentence.
          const piece = read(literal!).replace(/`[^`]*`?/g, '`').split('`')[0]!.trim();
          const bare = piece.replace(/^[';, ().]+|[' (]+$/g, '');
          if (!/[a-z]+ [a-z]+ [a-z]+/.test(bare) || /^write|^did you mean|^a[n]? [a-z]+ [a-z]+$/.test(bare)) continue;
          ++seen;
          if (!rows.includes(bare.replace(/ the$/, '')) && sentenceOf(`${piece} 'x'`) === null && adviceOf(piece) === null) lacks.push(`${file.replace(/.*\//, '')}: ${piece}`);
        }
    expect(seen).toBeGreaterThan(150);
    expect(lacks).toEqual([]);
  });

  it('has no sentence that nothing says any more', async () => {
    const {advices, sentences} = await import('../src/i18n/es/sentences');
    const all = Object.values(import.meta.glob('../../polyarm/{language,program,base,calibration,operation,setup,tasks,inside,requests,cell,hardware}/*.{cpp,hpp}', {query: '?raw', import: 'default', eager: true}) as Record<string, string>)
                    .map((text) => read(text.replace(/"\s+"/g, ''))).join('\n');
    const stale = [...sentences, ...advices].map(([english]) => english).filter(
        (english) => {
          const pieces = english.split(/'?\{\d\}'?|[;:,]/).map((piece) => piece.trim()).filter((piece) => /[a-z] [a-z]/.test(piece));
          return pieces.length > 0 && !pieces.some((piece) => all.includes(piece) || all.includes(piece.split(' ').slice(0, 4).join(' ')) || all.includes(piece.replace(/ has no meaning here$/, '')));
        });
    expect(stale).toEqual([]);
  });

  it('has a sentence for every code of files, and none that no file has', async () => {
    const {files} = await import('../src/i18n/es/files');
    const rooms = Object.entries(import.meta.glob('../../polyarm/{language,program,catalogue,clouds,collision,description,setup,xacro,yaml,ros_files,users,base,cell,data,signals,io}/*.cpp', {query: '?raw', import: 'default', eager: true}) as Record<string, string>);
    const kCode = /(?:Problem\s*\{|\bError\(|SyntaxError\{|\b(?:error|warning)\()\s*(?:[^"();{}]{0,60}\?\s*)?"([a-z][a-z0-9]*(?:-[a-z0-9]+)*)"(?:\s*:\s*"([a-z][a-z0-9]*(?:-[a-z0-9]+)*)")?/g;
    const codesOf = new Set(rooms.flatMap(([, text]) => [...text.matchAll(kCode)].flatMap(([, a, b]) => [a!, b!].filter(Boolean))));
    expect(codesOf.size).toBeGreaterThan(200);
    expect([...codesOf].filter((code) => !(`told.${code}` in en) && !(code in files))).toEqual([]);
    const all = [...rooms.map(([, text]) => text), ...Object.values(sources)].join('\n');
    expect(Object.keys(files).filter((code) => `told.${code}` in en || !all.includes(`"${code}"`))).toEqual([]);
  });

  it('is said in Spanish with its names and types, and with its advice', async () => {
    settings.language.value = 'es';
    await tablesLoaded();
    const say = (what: string, advice = '', code = 'bad-type') => {
      const {text, detail, advice: todo} = findingWords({code, what, advice});
      return [text, detail, todo].filter(Boolean);
    };
    expect(say("there is nothing called 'Hone'; did you mean 'Home'?", 'names are data, points, tags and variables of `let`'))
        .toEqual(['No hay nada llamado «Hone»; ¿quería decir «Home»?', 'Los nombres son datos, puntos, señales y variables de `let`']);
    expect(say('own', 'check that it is connected and that its parameters are right')[2] ?? '').toBe('Compruebe que está conectado y que sus parámetros son correctos');
    expect(say('format() has 1 field and 2 values')).toEqual(['format() tiene 1 campo y 2 valores']);
    expect(say("'+' cannot take a number without unit and a length")).toEqual(['«+» no admite un número sin unidad y una longitud']);
    expect(say("'endwhile' in line 4 closes the 'while' of line 2 while the 'if' of line 3 is still open"))
        .toEqual(['«endwhile» en la línea 4 cierra el «while» de la línea 2 mientras el «if» de la línea 3 sigue abierto']);
    expect(say("'z' of offset() is a length, here is a number without unit", 'a length needs a unit: write 80mm'))
        .toEqual(['«z» de offset() es una longitud; aquí está un número sin unidad', 'Una longitud necesita una unidad: escriba 80mm']);
    expect(say("the link's own words", 'do as you like', 'yaml-syntax')).toEqual(['El YAML no se puede leer', "the link's own words", 'do as you like']);
    expect(say('the cell cannot be opened by this user', '', 'never-heard-of')[0], 'a row is not for another sentence').toBe('the cell cannot be opened by this user');
    expect(say("there is a 'func f' already, in line 2", 'choose another name')).toEqual(['Ya hay un «func f», en la línea 2', 'Elija otro nombre']);
    expect(say("'|' has no meaning here; write `or`")).toEqual(['«|» no significa nada aquí; escriba `or`']);
    expect(say("this '(' is not closed before the end of the line", "add ')'")).toEqual(['Este «(» no se cierra antes del final de la línea', 'Añada «)»']);
    expect(ownWords("'/' by zero")).toBe('«/» entre cero');
  });

  it('advises what can be done in the file, and nothing of a cell that runs', () => {
    const guard = {code: 'guard', what: 'own', advice: 'move the points', facts: {robot: 'arm', a: 'arm/tool', b: 'fixture wall', distance_m: 0.001, clearance_m: 0.005, doing: 'check'}};
    expect(findingWords(guard)).toEqual({text: 'arm would be stopped before a contact: arm/tool and wall, 1.0 mm at the nearest, 5.0 mm are kept', detail: '', advice: 'move the points'});
  });
});

describe('a robot whose own controller interpolates', () => {
  it('is never advised to be jogged here', () => {
    const hit = {code: 'contact', what: 'own', facts: {a: 'arm/tool', b: 'fixture table', depth_m: 0.001, doing: 'program'}};
    expect(problemWords(hit).advice).toMatch(/^Jog away/);
    forwardRobots.value = {names: ['arm'], all: false};
    expect(inBoth(() => problemWords(hit).advice)).toEqual(
        [en['do.contact.forward'], es['do.contact.forward']]);
    expect(problemWords({...hit, facts: {...hit.facts, a: 'left/tool'}}).advice).toBe(es['do.contact']);
    forwardRobots.value = {names: ['arm'], all: true};
    for (const code of ['contact', 'in-contact', 'collision-torque', 'forward-mode'])
      expect(inBoth(() => problemWords({code, what: 'own'}).advice).join(' '), code).not.toMatch(/Jog away slowly|modo manual|to points/);
  });
});

describe('guards', () => {
  it('have a sentence of their own for each reason of a stop', () => {
    const stop = sources['../../polyarm/operation/guards.cpp']!;
    for (const code of ['guard-workspace', 'guard-crowded', 'guard-deadlock']) expect(stop).toContain(`"${code}"`);
    const crowded = {code: 'guard-crowded', what: 'own', facts: {robot: 'arm'}};
    expect(inBoth(() => problemWords(crowded).text)).toEqual([
      'arm stands: more bodies are near its path than a guard can measure in time',
      'arm está parado: hay más cuerpos cerca de su camino de los que una protección puede medir a tiempo'
    ]);
    expect(inBoth(() => problemWords({code: 'guard-workspace', what: 'own', facts: {robot: 'arm'}}).text)[1]).toBe('arm paró antes de salir de su zona de trabajo');
  });
});
