/**
 * The picture without WebGL: the robot as lines, from the side and from above, with the objects around it.
 */
import { useEffect, useRef } from 'preact/hooks';
import { t } from '../i18n';
import { cell, parts, robot as shown } from '../state/cell';
import { beat } from '../state/live';
import { baseNow, chains, jointValues, scene } from '../state/models';
import { darkNow } from '../state/settings';
import type { Pose, Vec3 } from '../wire/types';
import { compose, kIdentity, rotate } from './chain';

interface Side {
  label: Parameters<typeof t>[0];
  across: (p: Vec3) => number;
  up: (p: Vec3) => number;
}
const sides: Side[] = [
  { label: 'view.side', across: (p) => p[0], up: (p) => p[2] },
  { label: 'view.top', across: (p) => -p[1], up: (p) => p[0] },
];

export function FlatView() {
  const canvas = useRef<HTMLCanvasElement>(null);
  // Renders again with the beat and with the other signals that it reads.
  beat.value;
  const now = [cell.value, chains.value, scene.value, parts.value, darkNow.value, shown.value];
  useEffect(() => {
    if (canvas.current) draw(canvas.current);
  });
  return (
    <>
      <canvas ref={canvas} role="img" aria-label={t('view.canvas')} data-drawn={now.length > 0} />
      <p class="view-note">{t('view.flat')}</p>
    </>
  );
}

function draw(canvas: HTMLCanvasElement): void {
  const box = canvas.parentElement!.getBoundingClientRect();
  const ratio = Math.min(devicePixelRatio, 2);
  canvas.width = box.width * ratio;
  canvas.height = box.height * ratio;
  const pen = canvas.getContext('2d');
  if (!pen) return;
  pen.scale(ratio, ratio);
  const color = (name: string) => getComputedStyle(canvas).getPropertyValue(name).trim();
  sides.forEach((side, i) => {
    pen.save();
    pen.translate((i * box.width) / 2, 0);
    drawSide(pen, side, box.width / 2, box.height, color);
    pen.restore();
  });
}

function drawSide(pen: CanvasRenderingContext2D, side: Side, width: number, height: number, color: (name: string) => string): void {
  const sticks = robots();
  const reach = Math.max(0.3, ...Object.values(chains.peek()).map((chain) => chain.reach()));
  const scale = Math.min(width, height) / (2.5 * reach);
  const x = (p: Vec3) => width / 2 + scale * side.across(p);
  const y = (p: Vec3) => height * (side.label === 'view.top' ? 0.5 : 0.72) - scale * side.up(p);
  const line = (points: Vec3[], close = false) => {
    pen.beginPath();
    points.forEach((p, i) => (i ? pen.lineTo(x(p), y(p)) : pen.moveTo(x(p), y(p))));
    if (close) pen.closePath();
    pen.stroke();
  };
  pen.fillStyle = color('--muted');
  pen.font = '13px system-ui';
  pen.fillText(t(side.label), 12, height - 36);  // above the note, below the keys of a page
  pen.strokeStyle = color('--line-strong');
  pen.lineWidth = 1;
  for (const edges of boxes()) line(edges, true);
  pen.lineWidth = 6;
  pen.lineCap = pen.lineJoin = 'round';
  for (const { robot, segments } of sticks) {
    pen.strokeStyle = color(robot === shown.peek()?.name ? '--accent' : '--muted');
    for (const [a, b] of segments) line([a, b]);
    if (sticks.length > 1 && segments[0]) pen.fillText(robot, x(segments[0][0]) + 10, y(segments[0][0]) + 16);
  }
}

/** Each robot as lines from joint to joint. */
function robots(): { robot: string; segments: [Vec3, Vec3][] }[] {
  const out: { robot: string; segments: [Vec3, Vec3][] }[] = [];
  for (const info of cell.peek()?.robots ?? []) {
    const chain = chains.peek()[info.name];
    if (!chain) continue;
    const solved = chain.solve(jointValues(info.name));
    const base = baseNow(info.name) ?? info.base;
    const inWorld = (p: Vec3) => compose(base, { p, q: kIdentity }).p;
    out.push({ robot: info.name, segments: chain.segments(solved).map(([a, b]): [Vec3, Vec3] => [inWorld(a), inWorld(b)]) });
  }
  return out;
}

/** The visible outlines of objects: their bounding boxes, corner by corner. */
function boxes(): Vec3[][] {
  const out: Vec3[][] = [];
  for (const thing of scene.peek()?.things ?? []) {
    const at: Pose = parts.peek()[thing.name] ?? thing;
    for (const visual of thing.visuals) {
      const size = visual.size ?? [2 * (visual.radius ?? 0.02), 2 * (visual.radius ?? 0.02), visual.length ?? 0.04];
      const pose = compose(at, visual.origin);
      for (const level of [-0.5, 0.5])
        out.push(
          [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]].map(([a, b]) => {
            const p = rotate(pose.q, [a! * size[0], b! * size[1], level * size[2]]);
            return [p[0] + pose.p[0], p[1] + pose.p[1], p[2] + pose.p[2]] as Vec3;
          }),
        );
    }
  }
  return out;
}
