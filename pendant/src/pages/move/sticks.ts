/** Converts a gamepad's sticks into a jog command. Buttons are those of the standard mapping. */
const kDead = 0.18;
const kHoldButton = 5;

/** The jog command as fractions of the speed; null while the enabling button is not held. */
export function sticks(pad: { axes: readonly number[]; buttons: readonly { pressed: boolean; value: number }[] }): number[] | null {
  if (!pad.buttons[kHoldButton]?.pressed) return null;
  const at = (i: number) => {
    const value = pad.axes[i] ?? 0;
    return Math.abs(value) < kDead ? 0 : Math.max(-1, Math.min(1, (value - Math.sign(value) * kDead) / (1 - kDead)));
  };
  const lift = (pad.buttons[7]?.value ?? 0) - (pad.buttons[6]?.value ?? 0);
  const roll = Number(pad.buttons[15]?.pressed ?? 0) - Number(pad.buttons[14]?.pressed ?? 0);
  return [-at(1), -at(0), Math.abs(lift) < 0.05 ? 0 : lift, roll, at(3), -at(2)].map((v) => Math.round(v * 100) / 100 + 0);
}
