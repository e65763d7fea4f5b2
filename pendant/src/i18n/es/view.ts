import type { view as en } from '../en/view';

export const view: Record<keyof typeof en, string> = {
  'view.label': 'Vista del robot',
  'view.canvas': 'El robot y su entorno. Las flechas giran la vista; más y menos acercan y alejan.',
  'view.fit': 'Ajustar todo a la vista',
  'view.views': 'Vistas',
  'view.free': 'Perspectiva',
  'view.front': 'Frente',
  'view.side': 'Lado',
  'view.top': 'Planta',
  'view.layers': 'Qué se muestra',
  'view.trail': 'Traza del TCP',
  'view.plan': 'Trayectoria planificada',
  'view.frames': 'Sistemas de coordenadas',
  'view.zones': 'Zonas y cajas',
  'view.clearTrail': 'Borrar traza',
  'view.flat': 'Vista simple: este navegador no tiene WebGL.',
  'view.contact': '{a} – {b}: {mm} mm',
};
