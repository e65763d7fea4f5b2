/**
 * Files that are dropped anywhere on the page: meshes for the scene. Without this the browser would leave the page and show
 * the file.
 */
import { t } from '../i18n';
import { complain, mayProgram, youHold } from '../state/cell';
import { toast } from '../state/toasts';

export function startDrops(): void {
  addEventListener('dragover', (event) => {
    if (event.dataTransfer?.types.includes('Files')) event.preventDefault();
  });
  addEventListener('drop', (event) => {
    const files = [...(event.dataTransfer?.files ?? [])];
    if (files.length === 0) return;
    event.preventDefault();
    if (!mayProgram.value) return toast({ kind: 'warning', text: t(youHold.value ? 'told.no-role' : 'told.no-control') });
    import('../pages/cell/AddMesh').then(({ addMeshes }) => addMeshes(files)).catch(complain);
  });
}
