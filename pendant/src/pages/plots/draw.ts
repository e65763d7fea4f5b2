/** Draws one plot with uPlot. A chunk of its own. */
import uPlot from 'uplot';
import 'uplot/dist/uPlot.min.css';
import { number } from '../../i18n';
import { decimalsOf } from '../../ui/format';
import type { Slice } from './history';
import { leastSpan, padded } from './span';

export interface View {
  from: number;
  to: number;
}
interface Drawn {
  name: string;
  colour: string;
  dashed: boolean;
}
interface Hooks {
  onZoom: (from: number, to: number) => void;
  onCursor: (time: number | null) => void;
  onReset: () => void;
}

export class Plot {
  private readonly plot: uPlot;
  private readonly sizes: ResizeObserver;

  constructor(box: HTMLElement, unit: string, list: Drawn[], hooks: Hooks) {
    const style = getComputedStyle(document.documentElement);
    const ink = style.getPropertyValue('--muted').trim();
    const grid = { stroke: style.getPropertyValue('--line').trim(), width: 1 };
    const axis = { stroke: ink, grid, ticks: grid, font: '13px system-ui, sans-serif' };
    this.plot = new uPlot(
      {
        width: Math.max(100, box.clientWidth),
        height: Math.max(100, box.clientHeight),
        legend: { show: false },
        cursor: {
          sync: { key: 'polyarm' },
          drag: { x: true, y: false, setScale: false },
          bind: { dblclick: () => () => (hooks.onReset(), null) },
        },
        scales: { x: { time: false }, y: { range: (_, min, max) => padded(min, max, leastSpan(unit)) } },
        axes: [
          { ...axis, values: (_, ticks, __, ___, step) => ticks.map((tick) => `${number(tick, decimalsOf(step))} s`) },
          { ...axis, size: 70, values: (_, ticks, __, ___, step) => ticks.map((tick) => number(tick, decimalsOf(step))), label: unit || undefined, labelSize: unit ? 18 : 0, labelFont: '13px system-ui, sans-serif' },
        ],
        series: [
          {},
          ...list.map((each) => ({
            label: each.name, stroke: each.colour, width: each.dashed ? 1.5 : 2, dash: each.dashed ? [7, 5] : undefined, points: { show: false }, spanGaps: false,
          })),
        ],
        hooks: {
          setSelect: [
            (plot) => {
              const { left, width } = plot.select;
              if (width < 8) return;
              hooks.onZoom(plot.posToVal(left, 'x'), plot.posToVal(left + width, 'x'));
              plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
            },
          ],
          setCursor: [
            (plot) => {
              const { left } = plot.cursor;
              hooks.onCursor(left !== undefined && left !== null && left >= 0 ? plot.posToVal(left, 'x') : null);
            },
          ],
        },
      },
      [[], ...list.map(() => [])] as unknown as uPlot.AlignedData,
      box,
    );
    this.sizes = new ResizeObserver(() => this.plot.setSize({ width: Math.max(100, box.clientWidth), height: Math.max(100, box.clientHeight) }));
    this.sizes.observe(box);
  }

  show(slice: Slice, view: View): void {
    this.plot.batch(() => {
      this.plot.setData([slice.times, ...slice.columns] as uPlot.AlignedData, false);
      this.plot.setScale('x', { min: view.from, max: view.to });
    });
  }

  end(): void {
    this.sizes.disconnect();
    this.plot.destroy();
  }
}

