/** Icons of this page, 24 × 24, in the colour of the text. */
const shapes = {
  run: 'M7 4.500v15l12-7.500z',
  pause: 'M8 5v14M16 5v14',
  stop: 'M6 6h12v12H6z',
  record: 'M12 6a6 6 0 1 1 0 12 6 6 0 0 1 0-12z',
  step: 'M5 5v14l9-7zM18 5v14',
  program: 'M6 3h9l4 4v14H6zM9.500 11h6M9.500 15h6',
  move: 'M12 3v18M3 12h18M12 3l-2.500 2.500M12 3l2.500 2.500M12 21l-2.500-2.500M12 21l2.500-2.500M3 12l2.500-2.500M3 12l2.500 2.500M21 12l-2.500-2.500M21 12l-2.500 2.500',
  points: 'M12 21c4.500-5.200 6.500-8.600 6.500-11.500a6.500 6.500 0 0 0-13 0C5.500 12.400 7.500 15.800 12 21zM12 7.500a2 2 0 1 1 0 4 2 2 0 0 1 0-4z',
  signals: 'M3 16h4V8h5v8h5V8h4',
  plots: 'M4 4v16h16M7 15l4-5 3 3 5-7',
  health: 'M3 12h4l2.500-6 4 12 2.500-6h5',
  cell: 'M4 20V9l8-5 8 5v11zM9 20v-6h6v6',
  more: 'M6 12h.01M12 12h.01M18 12h.01',
  alarm: 'M12 4 2.500 20h19zM12 10v5M12 17.500v.01',
  check: 'M5 12.500l4.500 4.500L19 7.500',
  close: 'M6 6l12 12M18 6 6 18',
  settings: 'M12 9a3 3 0 1 1 0 6 3 3 0 0 1 0-6zM12 3v3M12 18v3M3 12h3M18 12h3M5.600 5.600l2.200 2.200M16.200 16.200l2.200 2.200M5.600 18.400l2.200-2.200M16.200 7.800l2.200-2.200',
  hand: 'M8 12V6.500a1.500 1.500 0 0 1 3 0V11V5a1.500 1.500 0 0 1 3 0v6-4.500a1.500 1.500 0 0 1 3 0V14c0 4-2.500 7-6 7-3 0-4.300-1.500-6-4.500L3.800 13a1.500 1.500 0 0 1 2.500-1.600L8 14',
  eye: 'M2.500 12S6 5.500 12 5.500 21.500 12 21.500 12 18 18.500 12 18.500 2.500 12 2.500 12zM12 9.500a2.500 2.500 0 1 1 0 5 2.500 2.500 0 0 1 0-5z',
  plus: 'M12 5v14M5 12h14',
  minus: 'M5 12h14',
  up: 'M6 15l6-6 6 6',
  down: 'M6 9l6 6 6-6',
  left: 'M15 6l-6 6 6 6',
  right: 'M9 6l6 6-6 6',
  turnLeft: 'M4 9h10a5.500 5.500 0 0 1 0 11h-4M4 9l4-4M4 9l4 4',
  turnRight: 'M20 9H10a5.500 5.500 0 0 0 0 11h4M20 9l-4-4M20 9l-4 4',
  fit: 'M4 9V4h5M20 9V4h-5M4 15v5h5M20 15v5h-5',
  cube: 'M12 3l8 4.500v9L12 21l-8-4.500v-9zM4 7.500l8 4.500 8-4.500M12 12v9',
  target: 'M12 5a7 7 0 1 1 0 14 7 7 0 0 1 0-14zM12 2v5M12 17v5M2 12h5M17 12h5',
  trail: 'M4 18c3 0 3-6 6-6s3-7 9-7M19 5h.01M4 18h.01',
  layers: 'M12 4l9 5-9 5-9-5zM3 14l9 5 9-5',
  gamepad: 'M7 8h10a5 5 0 0 1 4.500 7l-.7 1.500a2 2 0 0 1-3.300.5L15.500 15h-7L6.500 17a2 2 0 0 1-3.300-.5L2.500 15A5 5 0 0 1 7 8zM7 10.500v3M5.500 12h3M16 11v.01M18 13v.01',
  keyboard: 'M3 7h18v10H3zM6.500 10.500h.01M10 10.500h.01M13.500 10.500h.01M17 10.500h.01M8 14h8',
  lock: 'M6 11h12v9H6zM8.500 11V8a3.500 3.500 0 0 1 7 0v3',
  link: 'M9.500 14.500l5-5M8 11l-2.500 2.500a3.500 3.500 0 0 0 5 5L13 16M11 8l2.500-2.500a3.500 3.500 0 0 1 5 5L16 13',
  help: 'M9 9a3 3 0 1 1 4.500 2.600c-1 .6-1.500 1.200-1.500 2.400M12 17.500v.01M12 3a9 9 0 1 1 0 18 9 9 0 0 1 0-18z',
  search: 'M11 5a6 6 0 1 1 0 12 6 6 0 0 1 0-12zM15.500 15.500 20 20',
  edit: 'M4 20l1-4L16.500 4.500l3 3L8 19zM14 7l3 3',
  trash: 'M5 7h14M9.500 7V4h5v3M7 7l1 13h8l1-13',
  copy: 'M8 8h11v12H8zM5 16V4h11',
  download: 'M12 4v11M7.500 11l4.500 4.500 4.500-4.500M4 20h16',
  upload: 'M12 16V5M7.500 9 12 4.500 16.500 9M4 20h16',
  undo: 'M4 9h10a5.500 5.500 0 0 1 0 11h-4M4 9l4-4M4 9l4 4',
  save: 'M5 4h11l3 3v13H5zM8 4v5h7V4M8 20v-6h8v6',
  clock: 'M12 4a8 8 0 1 1 0 16 8 8 0 0 1 0-16zM12 8v4.500l3 2',
  repeat: 'M5 12V9a3 3 0 0 1 3-3h11M16 3l3 3-3 3M19 12v3a3 3 0 0 1-3 3H5M8 21l-3-3 3-3',
  folder: 'M3 6h6l2 2.500h10V19H3z',
  power: 'M12 3v8M7 6.500a7.500 7.500 0 1 0 10 0',
  pin: 'M12 21v-6M8 4h8l-1 6 3 3v2H6v-2l3-3z',
} as const;

export type IconName = keyof typeof shapes;
const filled: ReadonlySet<IconName> = new Set<IconName>(['run', 'stop', 'record']);
const heavy: ReadonlySet<IconName> = new Set<IconName>(['more', 'pause']);

export function Icon({ name, size = 24, class: className = '' }: { name: IconName; size?: number; class?: string }) {
  const fill = filled.has(name);
  return (
    <svg
      class={`icon ${className}`}
      viewBox="0 0 24 24"
      width={size}
      height={size}
      aria-hidden="true"
      fill={fill ? 'currentColor' : 'none'}
      stroke="currentColor"
      stroke-width={heavy.has(name) ? 3 : 1.8}
      stroke-linecap="round"
      stroke-linejoin="round"
    >
      <path d={shapes[name]} />
      {name === 'step' && <path d="M5 5v14l9-7z" fill="currentColor" />}
    </svg>
  );
}
