// The light: one word for what the projectors show.

import { byId, make, setAttribute, setText } from './elements.js';
import { brightnessNote } from './show.js';

// The word, the reason and the kind of a state.
export function lightOf({ blackout, paused, test_picture: picture, brightness, cameras }) {
  const by = (who) => (who ? `set by ${who}` : '');
  const dark = cameras.filter((camera) => camera.dark !== null);
  const reasons = [...new Set(dark.map((camera) => camera.dark))].join('; ');
  if (blackout.on) {
    return ['black', 'Black', by(blackout.by)];
  }
  if (cameras.length === 0) {
    return ['dark', 'No camera', 'the config has no camera'];
  }
  if (dark.length === cameras.length) {
    return cameras.every((camera) => camera.blackout) ? ['black', 'Black', reasons] : ['dark', 'Dark', reasons];
  }
  if (brightness.share === 0) {
    return ['dark', 'Dark', brightnessNote(brightness)];
  }
  const some = dark.map((camera) => `${camera.name} is dark: ${camera.dark}`).join('; ');
  const dim = brightnessNote(brightness);
  if (picture !== null) {
    return ['test', 'Test picture', [picture, dim, some].filter(Boolean).join('; ')];
  }
  if (paused.on) {
    return ['paused', 'Paused', [by(paused.by), dim, some].filter(Boolean).join('; ')];
  }
  return some ? ['dark', `${dark.length} of ${cameras.length} dark`, [dim, some].filter(Boolean).join('; ')] : ['lit', 'Lit', dim];
}

const LIGHTS = { lit: '#ffe082', dark: '#ffc857', black: '#000', paused: '#4ea1e0', test: '#9575cd', lost: '#e53935' };
// A disc for each light. Browsers may load one later than it is set, so that all of them stay.
const ICONS = Object.fromEntries(Object.entries(LIGHTS).map(([light, color]) => {
  const disc = `<circle cx="16" cy="16" r="13" fill="${color}" stroke="#fff" stroke-width="3"/>`;
  const svg = `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 32 32">${disc}</svg>`;
  return [light, URL.createObjectURL(new Blob([svg], { type: 'image/svg+xml' }))];
}));
// There before the page has loaded: browsers ask for /favicon.ico otherwise.
const icon = document.head.appendChild(make('link', { rel: 'icon', href: ICONS.lost }));
let shownLight = '';

// Shows the light in the rail and, when its word changes, in the tab and to screen readers.
export function showLight([kind, word, why]) {
  setText(byId('light-word'), word);
  setText(byId('light-why'), why);
  setAttribute(byId('light'), 'data-light', kind);
  document.body.toggleAttribute('data-lost', kind === 'lost');
  if (kind + word !== shownLight) {
    shownLight = kind + word;
    setText(byId('announcement'), word);
    document.title = `${word} – camera_stream`;
    icon.href = ICONS[kind];
  }
}
