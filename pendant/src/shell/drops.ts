/**
 * Files that are dropped anywhere on the page: meshes for the scene. Without this the browser would leave the page and show
 * the file. The text of a program does not take them either: an editor would insert what they contain.
 */
import { t } from '../i18n';
import { complain, mayProgram, youHold } from '../state/cell';
import { toast } from '../state/toasts';

export function startDrops(): void {
  addEventListener('dragover', (event) => {
    if (event.dataTransfer?.types.includes('Files')) event.preventDefault();
  });
  const onDrop = (event: DragEvent) => {
    const files = [...(event.dataTransfer?.files ?? [])];
    if (files.length === 0) return;
    event.preventDefault();
    event.stopPropagation();
    if (!mayProgram.value) return toast({ kind: 'warning', text: t(youHold.value ? 'told.no-role' : 'told.no-control') });
    import('../pages/cell/AddMesh').then(({ addMeshes }) => addMeshes(files)).catch(complain);
  };
  addEventListener('drop', onDrop, { capture: true });
}
