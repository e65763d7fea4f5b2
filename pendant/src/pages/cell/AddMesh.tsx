/** Meshes that are dropped on the page, or chosen, become fixtures or parts of the scene. */
import { signal } from '@preact/signals';
import { useRef, useState } from 'preact/hooks';
import { number, t } from '../../i18n';
import { complain, mayProgram, request } from '../../state/cell';
import { loadScene } from '../../state/models';
import { toast } from '../../state/toasts';
import { open } from '../../ui/ask';
import { Button, Field, Segmented, Select } from '../../ui/controls';
import { Dialog } from '../../ui/Dialog';
import type { Vec3 } from '../../wire/types';
import { isMesh, kEndings, kUnits, place, sceneName, upload, type Uploaded } from './mesh';
import { restart, restarting } from './restart';

/** The upload that is under way, 0 to 1; null: none. */
const share = signal<number | null>(null);

/** Uploads the files and asks for each mesh how it is placed. */
export async function addMeshes(files: File[]): Promise<void> {
  if (share.value !== null) return;
  if (!files.some((each) => isMesh(each.name))) {
    toast({ kind: 'warning', text: t('mesh.none', { endings: kEndings.join(', ') }) });
    return;
  }
  share.value = 0;
  try {
    for (const mesh of await upload(files, (done) => (share.value = done)))
      await new Promise<void>((resolve) => open((close) => <Place mesh={mesh} onClose={() => (close(), resolve())} />));
  } catch (error) {
    complain(error);
  } finally {
    share.value = null;
  }
}

export function AddMesh() {
  const input = useRef<HTMLInputElement>(null);
  const done = share.value;
  return (
    <>
      <Button
        label={done === null ? t('mesh.add') : t('mesh.uploading', { percent: number(100 * done, 0) })}
        icon="cube"
        disabled={!mayProgram.value || done !== null || restarting.value !== ''}
        onClick={() => input.current?.click()}
      />
      <input
        ref={input}
        type="file"
        hidden
        multiple
        accept={[...kEndings, '.mtl', '.png', '.jpg', '.jpeg'].join(',')}
        aria-label={t('mesh.add')}
        onChange={(e) => {
          const files = [...(e.currentTarget.files ?? [])];
          e.currentTarget.value = '';
          void addMeshes(files);
        }}
      />
    </>
  );
}

type Kind = 'fixture' | 'part';

function Place({ mesh, onClose }: { mesh: Uploaded; onClose: () => void }) {
  const [name, setName] = useState(sceneName(mesh.file));
  const [kind, setKind] = useState<Kind>('fixture');
  const [unit, setUnit] = useState(mesh.metres ? 'm' : mesh.likely);
  const [at, setAt] = useState(place(mesh, unit).map(String));
  const [turn, setTurn] = useState(['0', '0', '0']);
  const [mass, setMass] = useState('0.1');
  const [busy, setBusy] = useState(false);
  const value = (text: string) => (text.trim() === '' ? NaN : Number(text.replace(',', '.')));
  const bad = (text: string, least = -Infinity) => (Number.isFinite(value(text)) && value(text) > least ? undefined : t('signals.badNumber'));
  const metres = mesh.metres ? 1 : (kUnits[unit] ?? 1);
  const size = mesh.size.map((each) => number(each * metres, 3)).join(' × ');
  const wrong = !/^[A-Za-z_][A-Za-z0-9_]*$/.test(name) || [...at, ...turn].some((each) => bad(each)) || (kind === 'part' && !!bad(mass, 0));
  const chooseUnit = (next: string) => {
    setUnit(next);
    setAt(place(mesh, next).map(String));
  };
  const put = (list: string[], index: number, text: string) => list.map((each, i) => (i === index ? text : each));
  const add = async () => {
    setBusy(true);
    try {
      await request('scene.add', {
        name,
        file: mesh.file,
        unit,
        at: at.map(value) as Vec3,
        rpy: turn.map((each) => (value(each) * Math.PI) / 180) as Vec3,
        ...(kind === 'part' ? { mass: value(mass) } : {}),
      });
      onClose();
      if (await restart(t('mesh.adding', { name }), t('mesh.added', { name }), 'cell.reset', {})) await loadScene();
    } catch (error) {
      complain(error);
      setBusy(false);
    }
  };
  return (
    <Dialog
      title={t('mesh.title')}
      onClose={onClose}
      actions={
        <>
          <Button label={t('dialog.cancel')} onClick={onClose} />
          <Button label={t('mesh.addDo')} tone="primary" disabled={wrong || busy || restarting.value !== '' || !mayProgram.value} onClick={() => void add()} />
        </>
      }
    >
      <Field label={t('mesh.name')} value={name} problem={/^[A-Za-z_][A-Za-z0-9_]*$/.test(name) ? undefined : t('cell.badName')} onInput={setName} />
      <Segmented<Kind>
        label={t('mesh.kind')}
        value={kind}
        options={[
          { id: 'fixture', name: t('mesh.fixture') },
          { id: 'part', name: t('mesh.part') },
        ]}
        onChange={setKind}
      />
      {mesh.metres ? (
        <p class="note">{t('mesh.unitKnown')}</p>
      ) : (
        <Select label={t('mesh.unit')} value={unit} options={Object.keys(kUnits).map((id) => ({ id, name: id }))} onChange={chooseUnit} />
      )}
      <p class="note" role="status">
        {t('mesh.size', { size, count: mesh.triangles })}
      </p>
      {kind === 'part' && <Field label={t('cell.mass')} value={mass} unit="kg" numeric problem={bad(mass, 0)} onInput={setMass} />}
      <div class="row">
        {['x', 'y', 'z'].map((axis, i) => (
          <Field key={axis} label={axis} value={at[i]!} unit="m" numeric problem={bad(at[i]!)} onInput={(text) => setAt(put(at, i, text))} />
        ))}
      </div>
      <div class="row">
        {[t('mesh.roll'), t('mesh.pitch'), t('mesh.yaw')].map((label, i) => (
          <Field key={label} label={label} value={turn[i]!} unit="°" numeric problem={bad(turn[i]!)} onInput={(text) => setTurn(put(turn, i, text))} />
        ))}
      </div>
      <p class="note">{t('mesh.restarts')}</p>
    </Dialog>
  );
}
