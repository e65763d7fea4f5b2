/** The robot's picture on a page: in 3D with WebGL, else as lines. */
import { computed, effect, signal } from '@preact/signals';
import { useEffect, useRef, useState } from 'preact/hooks';
import { t } from '../i18n';
import { cell, connected, nears, parts, plans, robot, status } from '../state/cell';
import { newestFrame, onFrame, valueNow } from '../state/live';
import { baseNow, frames, jointValues, models, scene } from '../state/models';
import { chosenPoints, dryPaths, pointsIn3d, problemsIn3d } from '../state/preview';
import { darkNow, kept } from '../state/settings';
import { Button, Loading } from '../ui/controls';
import type { Touch, Vec3 } from '../wire/types';
import { FlatView } from './FlatView';
import { slowedWords } from './slowed';
import type { CellPicture, Ghost, Handle, Layers } from './picture';
import type { ViewName } from './stage';
import './view.css';

/** A page's preview, shown instead of the plan from the cell. */
export const preview = signal<{ robot: string; path: Vec3[]; joints: Record<string, number> | null } | null>(null);
export const handle = signal<Handle | null>(null);
const kLayers: Layers = { trail: true, plan: true, frames: false, zones: true, things: true, names: false, near: true };
const layers = kept<Layers>('layers', kLayers);
layers.value = { ...kLayers, ...layers.peek() };  // an older page kept fewer

function webgl(): boolean {
  try {
    return !!document.createElement('canvas').getContext('webgl2');
  } catch {
    return false;
  }
}
const canDraw = webgl();
/** Compared as text, so that a status without changes redraws nothing. */
const told = computed(() => JSON.stringify((status.value?.contacts.list ?? []).filter((each) => each.now)));
const touching = computed(() => JSON.parse(told.value) as Touch[]);

export function RobotView() {
  const [failed, setFailed] = useState(!canDraw);
  return (
    <section class="view" aria-label={t('view.label')}>
      {!connected.value && cell.value && <p class="view-old">{t('link.oldPicture')}</p>}
      {failed ? <FlatView /> : <Picture onFail={() => setFailed(true)} />}
      <Slowed />
    </section>
  );
}

/** Says why a planned move is slower than it was planned. */
function Slowed() {
  const text = slowedWords(Object.values(nears.value), (cell.value?.robots ?? []).map((each) => each.name), status.value?.state === 'running');
  return text ? <p class="view-slowed">{text}</p> : null;
}

function Picture({ onFail }: { onFail: () => void }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const [picture, setPicture] = useState<CellPicture | null>(null);
  useEffect(() => {
    let made: CellPicture | null = null;
    let gone = false;
    const endings: (() => void)[] = [];
    import('./picture').then(
      ({ CellPicture: Made }) => {
        if (gone || !canvas.current) return;
        try {
          made = new Made(canvas.current);
        } catch (error) {
          console.warn('no 3D picture', error);
          return onFail();
        }
        endings.push(...follow(made));
        setPicture(made);
      },
      () => onFail(),
    );
    return () => {
      gone = true;
      endings.forEach((end) => end());
      made?.end();
    };
  }, []);
  return (
    <>
      <canvas
        ref={canvas}
        role="img"
        tabIndex={0}
        aria-label={t('view.canvas')}
        onKeyDown={(e) => {
          if (picture?.stage.key(e.key)) e.preventDefault();
        }}
      />
      {picture ? <Tools picture={picture} /> : <Loading />}
    </>
  );
}

/** Connects the picture to the signals and the frames. Returns the functions that disconnect it. */
function follow(picture: CellPicture): (() => void)[] {
  const update = () => {
    picture.updateMovers(valueNow);
    for (const each of cell.peek()?.robots ?? []) {
      const name = each.name;
      const tcp: Vec3 = [valueNow(`${name}/tcp/x`), valueNow(`${name}/tcp/y`), valueNow(`${name}/tcp/z`)];
      picture.update(name, jointValues(name), tcp, baseNow(name) ?? undefined);
      picture.updateGripper(name, valueNow(`${name}/tool/width`));
    }
  };
  return [
    effect(() => picture.setTheme(darkNow.value)),
    effect(() => {
      picture.setRobots(cell.value?.robots ?? [], models.value);
      picture.setShown(robot.value?.name ?? '');
      if (newestFrame()) update();
    }),
    effect(() => {
      if (scene.value) picture.setScene(scene.value);
      picture.setLayers(layers.value);
      picture.setParts(parts.peek());
    }),
    effect(() => picture.setFrames(frames.value)),
    effect(() => picture.setPoints(pointsIn3d.value, chosenPoints.value)),
    effect(() => picture.setDryRun(dryPaths.value, problemsIn3d.value)),
    effect(() => picture.setParts(parts.value)),
    effect(() => {
      scene.value;
      models.value;
      picture.setContacts(touching.value);
    }),
    effect(() => picture.setLayers(layers.value)),
    effect(() => picture.setNear(Object.values(nears.value))),
    effect(() => showPlans(picture)),
    effect(() => picture.setHandle(handle.value)),
    onFrame(update),
  ];
}

function showPlans(picture: CellPicture): void {
  const shown = preview.value;
  for (const each of cell.value?.robots ?? []) {
    if (!models.value[each.name]) continue;
    if (shown?.robot === each.name) {
      picture.setPlan(each.name, { robot: each.name, path: shown.path, target: null });
      picture.setGhost(each.name, shown.joints);
      continue;
    }
    const plan = plans.value[each.name] ?? null;
    picture.setPlan(each.name, plan);
    picture.setGhost(each.name, ghostOf(each.name, plan?.target?.joints)?.joints ?? null);
  }
}

/** A target as joint values by name. The cell may send them as a list in the order of the robot's joints. */
function ghostOf(name: string, joints: number[] | Record<string, number> | undefined): Ghost | null {
  if (!joints) return null;
  if (!Array.isArray(joints)) return { robot: name, joints };
  const names = cell.peek()?.robots.find((one) => one.name === name)?.joints ?? [];
  return { robot: name, joints: Object.fromEntries(names.map((joint, i) => [joint.name, joints[i] ?? 0])) };
}

const views: { id: ViewName; label: Parameters<typeof t>[0] }[] = [
  { id: 'free', label: 'view.free' },
  { id: 'front', label: 'view.front' },
  { id: 'side', label: 'view.side' },
  { id: 'top', label: 'view.top' },
];
const shownLayers: { id: keyof Layers; label: Parameters<typeof t>[0] }[] = [
  { id: 'trail', label: 'view.trail' },
  { id: 'plan', label: 'view.plan' },
  { id: 'frames', label: 'view.frames' },
  { id: 'zones', label: 'view.zones' },
  { id: 'things', label: 'view.things' },
  { id: 'names', label: 'view.names' },
  { id: 'near', label: 'view.distances' },
];

function Tools({ picture }: { picture: CellPicture }) {
  const [openMenu, setOpenMenu] = useState<'views' | 'layers' | null>(null);
  const toggle = (menu: 'views' | 'layers') => setOpenMenu(openMenu === menu ? null : menu);
  return (
    <div class="view-tools">
      <Button label={t('view.fit')} icon="fit" bare onClick={() => picture.fit('free')} />
      <Button label={t('view.views')} icon="cube" bare pressed={openMenu === 'views'} onClick={() => toggle('views')} />
      <Button label={t('view.layers')} icon="layers" bare pressed={openMenu === 'layers'} onClick={() => toggle('layers')} />
      {openMenu === 'views' && (
        <div class="view-menu" role="group" aria-label={t('view.views')}>
          {views.map((view) => (
            <Button
              key={view.id}
              label={t(view.label)}
              tone="quiet"
              onClick={() => {
                picture.fit(view.id);
                setOpenMenu(null);
              }}
            />
          ))}
        </div>
      )}
      {openMenu === 'layers' && (
        <div class="view-menu" role="group" aria-label={t('view.layers')}>
          {shownLayers.map((layer) => (
            <Button
              key={layer.id}
              label={t(layer.label)}
              tone="quiet"
              pressed={layers.value[layer.id]}
              onClick={() => (layers.value = { ...layers.value, [layer.id]: !layers.value[layer.id] })}
            />
          ))}
          <Button label={t('view.clearTrail')} tone="quiet" icon="trail" onClick={() => picture.clearTrails()} />
        </div>
      )}
    </div>
  );
}

