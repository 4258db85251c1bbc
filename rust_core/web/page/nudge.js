// The pad that moves the light of a projector, by its frame in TF.

import { make, newId, setText } from './elements.js';
import { post } from './node.js';

const DEGREE = Math.PI / 180;
// For each button its place in three columns, its words, and its move in steps; null leaves a place empty. Buttons are called after
// the way of the light on the thing: the projector's frame goes the other way.
const MOVES = [
  [null, ['Up', { down_m: 1 }], null],
  [['Left', { right_m: 1 }], null, ['Right', { right_m: -1 }]],
  [['Larger', { forward_m: 1 }], ['Down', { down_m: -1 }], ['Smaller', { forward_m: -1 }]],
];
const TURNS = [
  [['Roll left', { roll_rad: 1 }], ['Tilt up', { pitch_rad: -1 }], ['Roll right', { roll_rad: -1 }]],
  [['Turn left', { yaw_rad: 1 }], null, ['Turn right', { yaw_rad: -1 }]],
  [null, ['Tilt down', { pitch_rad: 1 }], null],
];
const ARROWS = { ArrowUp: 'Up', ArrowDown: 'Down', ArrowLeft: 'Left', ArrowRight: 'Right' };
const SUM = { x: 'mm', y: 'mm', z: 'mm', roll: '°', pitch: '°', yaw: '°' };

// A choice of two steps, and a button for each direction.
function makePad(legend, steps, rows, onMove) {
  const group = newId();
  let step = steps[0][1];
  const choices = steps.map(([label, value], index) => {
    const choice = make('input', { type: 'radio', name: group, onchange: () => { step = value; } });
    choice.checked = index === 0;
    return make('label', {}, choice, label);
  });
  const buttons = new Map();
  const places = rows.flat().map((place) => {
    if (!place) {
      return make('span');
    }
    const [label, move] = place;
    const onclick = () => onMove(Object.fromEntries(Object.entries(move).map(([axis, steps]) => [axis, steps * step])), button);
    const button = make('button', { type: 'button', onclick }, label);
    buttons.set(label, button);
    return button;
  });
  const pad = make('div', { class: 'pad' }, ...places);
  pad.addEventListener('keydown', (event) => {
    const button = buttons.get(ARROWS[event.key]);
    if (button && !event.repeat) {
      event.preventDefault();
      button.click();
    }
  });
  return make('fieldset', {}, make('legend', {}, legend), make('div', { class: 'steps' }, ...choices), pad);
}

// The pad that moves the projector's frame, hidden where no projector can be nudged.
export function makeNudge(camera) {
  const move = (steps, button) => post('nudge', { camera, ...steps }, button);
  const title = make('summary');
  const problem = make('p', { class: 'problem' });
  const moves = makePad('Move the light', [['1 mm', 0.001], ['10 mm', 0.01]], MOVES, move);
  const turns = makePad('Turn the light', [['0.1°', 0.1 * DEGREE], ['1°', DEGREE]], TURNS, move);
  const values = Object.fromEntries(Object.keys(SUM).map((axis) => [axis, make('dd')]));
  const terms = Object.entries(values).map(([axis, value]) => make('div', {}, make('dt', {}, axis), value));
  const sum = make('dl', { class: 'sum' }, ...terms);
  const save = make('button', { type: 'button', onclick: () => post('save', { camera }, save) }, 'Save to the file');
  const revert = make('button', { type: 'button', onclick: () => post('revert', { camera }, revert) }, 'Revert');
  const note = make('p', {}, 'Directions are those of the light on the thing, seen from the projector. The numbers are the way of its frame in TF.');
  const node = make('details', { class: 'nudge' }, title, problem, note,
    make('div', { class: 'pads' }, moves, turns), sum, make('div', { class: 'buttons' }, save, revert));

  const update = (nudge) => {
    node.hidden = nudge === null;
    if (nudge === null) {
      return;
    }
    const isMoved = Object.keys(SUM).some((axis) => nudge[axis] !== 0);
    setText(title, `Nudge ${nudge.node}${isMoved ? ': moved, not saved' : ''}`);
    setText(problem, nudge.problem ?? '');
    for (const [axis, unit] of Object.entries(SUM)) {
      const value = unit === 'mm' ? `${(nudge[axis] * 1000).toFixed(1)} mm` : `${(nudge[axis] / DEGREE).toFixed(2)}°`;
      setText(values[axis], value);
    }
    moves.disabled = turns.disabled = nudge.problem !== null;
    save.disabled = revert.disabled = nudge.problem !== null || !isMoved;
  };
  return { node, update };
}
