/** Moves points by an offset, along the axes of their frame or their own axes. */
import { useState } from 'preact/hooks';
import { t } from '../../i18n';
import { mayProgram } from '../../state/cell';
import { changePoints } from '../../state/points';
import { settings } from '../../state/settings';
import { toast } from '../../state/toasts';
import { Button, Field, Segmented } from '../../ui/controls';
import { Dialog } from '../../ui/Dialog';
import { angleUnit, kDeg, kMm } from '../../ui/format';

const kAxes = ['x', 'y', 'z', 'rx', 'ry', 'rz'] as const;
const read = (text: string) => (text.trim() === '' ? 0 : Number(text.replace(',', '.').replace('−', '-')));

export function Shift({ names, onClose }: { names: string[]; onClose: () => void }) {
  const [along, setAlong] = useState<'frame' | 'own'>('frame');
  const [by, setBy] = useState<string[]>(['', '', '', '', '', '']);
  const numbers = by.map((text, i) => read(text) / (i < 3 ? kMm : settings.degrees.value ? kDeg : 1));
  const good = numbers.every(Number.isFinite) && numbers.some((value) => value !== 0);
  const go = async () => {
    if (!good) return;
    onClose();
    const shift = Object.fromEntries(kAxes.map((axis, i) => [axis, numbers[i]]));
    if (await changePoints('points.shift', { names, by: shift, along })) toast({ kind: 'ok', text: t('points.shifted', { names: names.join(', ') }) });
  };
  return (
    <Dialog
      title={t('points.shiftTitle', { names: names.join(', ') })}
      onClose={onClose}
      actions={
        <>
          <Button label={t('dialog.cancel')} onClick={onClose} />
          <Button label={t('points.shift')} tone="primary" disabled={!good || !mayProgram.value} onClick={() => void go()} />
        </>
      }
    >
      <Segmented
        label={t('points.along')}
        value={along}
        options={[
          { id: 'frame', name: t('points.alongFrame') },
          { id: 'own', name: t('points.alongOwn') },
        ]}
        onChange={setAlong}
      />
      <div class="points-six">
        {kAxes.map((axis, i) => (
          <Field
            key={axis}
            label={axis.toUpperCase()}
            value={by[i]!}
            placeholder="0"
            numeric
            unit={i < 3 ? 'mm' : angleUnit()}
            problem={Number.isFinite(numbers[i]!) ? undefined : t('goto.bad')}
            onInput={(text) => setBy(by.map((old, k) => (k === i ? text : old)))}
            onEnter={() => void go()}
          />
        ))}
      </div>
    </Dialog>
  );
}
