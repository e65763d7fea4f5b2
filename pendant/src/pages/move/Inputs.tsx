/** Jogs with the keyboard or a gamepad. Each must be switched on by hand, and works only on this page. */
import { signal } from '@preact/signals';
import { useEffect, useLayoutEffect } from 'preact/hooks';
import { t } from '../../i18n';
import { jogBlocked, mayMove } from '../../state/cell';
import { heldKey, jogMode, type JogMode, jogSpeed, pressJog, pushJog, release } from '../../state/jog';
import { frames } from '../../state/models';
import { canBe } from '../../state/ways';
import { toast } from '../../state/toasts';
import { Button } from '../../ui/controls';
import { axesNow } from './axes';
import { chooseMode } from './JogSettings';
import { sticks } from './sticks';

const keyboardOn = signal(false);
const gamepadOn = signal(false);
const kUp = ['KeyQ', 'KeyW', 'KeyE', 'KeyR', 'KeyT', 'KeyY', 'KeyU', 'KeyI'];
const kDown = ['KeyA', 'KeyS', 'KeyD', 'KeyF', 'KeyG', 'KeyH', 'KeyJ', 'KeyK'];
const kModes: JogMode[] = ['joint', 'base', 'tool', 'world', 'user'];

export function Inputs() {
  useEffect(() => () => ((keyboardOn.value = false), (gamepadOn.value = false), release()), []);
  useKeyboard();
  useGamepad();
  return (
    <>
      <Button
        label={t('move.keyboard')}
        icon="keyboard"
        title={t('move.keyboardWhy')}
        pressed={keyboardOn.value}
        disabled={!mayMove.value}
        onClick={() => (keyboardOn.value = !keyboardOn.value)}
      />
      <Button
        label={t('move.gamepad')}
        icon="gamepad"
        title={t('move.gamepadWhy')}
        pressed={gamepadOn.value}
        disabled={!mayMove.value}
        onClick={switchGamepad}
      />
    </>
  );
}

function switchGamepad(): void {
  gamepadOn.value = !gamepadOn.value;
  if (!gamepadOn.value) return;
  const there = navigator.getGamepads?.().some((pad) => pad !== null);
  toast({ kind: 'info', text: t(there ? 'move.gamepadWhy' : 'move.gamepadNone') });
}

function inText(event: KeyboardEvent): boolean {
  const target = event.target as HTMLElement;
  return target.matches?.('input:not([type=range]):not([type=radio]):not([type=checkbox]), select, textarea, [contenteditable]') ?? false;
}

function useKeyboard(): void {
  const on = keyboardOn.value;
  // A layout effect, so that a key works as soon as the button is shown as on.
  useLayoutEffect(() => {
    if (!on) return;
    let held = '';
    const down = (event: KeyboardEvent) => {
      if (event.altKey || event.ctrlKey || event.metaKey || inText(event) || !canBe(jogBlocked.peek())) return;
      const up = kUp.indexOf(event.code);
      const axis = up >= 0 ? up : kDown.indexOf(event.code);
      if (axis >= 0) {
        event.preventDefault();
        const wanted = axesNow()[axis];
        if (event.repeat || !wanted) return;
        held = event.code;
        pressJog(wanted.index, up >= 0 ? 1 : -1);
      } else if (event.code === 'KeyM' && !event.repeat) {
        release();
        const modes = frames.peek().length ? kModes : kModes.filter((each) => each !== 'user');
        chooseMode(modes[(modes.indexOf(jogMode.peek()) + 1) % modes.length]!);
      } else if (event.key === '+' || event.key === '-') {
        const factor = event.key === '+' ? 1.25 : 0.8;
        jogSpeed.value = Math.max(1, Math.min(100, Math.round(jogSpeed.peek() * factor)));
      }
    };
    const up = (event: KeyboardEvent) => {
      if (event.code !== held) return;
      held = '';
      release();
    };
    addEventListener('keydown', down);
    addEventListener('keyup', up);
    return () => {
      removeEventListener('keydown', down);
      removeEventListener('keyup', up);
      if (held) release();
    };
  }, [on]);
}

function useGamepad(): void {
  const on = gamepadOn.value;
  useEffect(() => {
    if (!on) return;
    const timer = setInterval(() => {
      const pad = navigator.getGamepads().find((each) => each !== null);
      const wish = pad ? sticks(pad) : null;
      const moves = wish?.some((v) => v !== 0) && canBe(jogBlocked.peek());
      if (moves) {
        if (jogMode.peek() === 'joint') jogMode.value = 'base';
        pushJog('gamepad', wish!);
      } else if (heldKey.peek() === 'gamepad') release();
    }, 30);
    return () => {
      clearInterval(timer);
      if (heldKey.peek() === 'gamepad') release();
    };
  }, [on]);
}
