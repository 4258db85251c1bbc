// A camera's image as its projector shows it, with figures of the last minute.

import { duration, make, makeStatuses, newId, rate, setAttribute, setText } from './elements.js';
import { black, post, release } from './node.js';
import { makeNudge } from './nudge.js';

const PLOT_SECS = 60;
// Hatching wider than this costs time and shows no more.
const MOST_MASK_PX = 640;

// A value now, and a plot of its last minute from 0 to its largest.
function makePlot(name, format) {
  const SVG = 'http://www.w3.org/2000/svg';
  const svg = document.createElementNS(SVG, 'svg');
  const path = svg.appendChild(document.createElementNS(SVG, 'path'));
  for (const [key, value] of Object.entries({ class: 'plot', role: 'img', viewBox: '0 0 60 20', preserveAspectRatio: 'none' })) {
    svg.setAttribute(key, value);
  }
  const now = make('span');
  const range = make('small');
  const node = make('div', {}, make('dt', {}, name), make('dd', {}, now, svg, range));
  let points = [];
  const add = (value) => {
    const time = performance.now() / 1000;
    points.push({ time, value });
    points = points.filter((point) => point.time > time - PLOT_SECS);
    const values = points.map((point) => point.value).filter((each) => each !== null);
    const most = Math.max(...values, Number.MIN_VALUE);
    let step = 'M';
    const draw = (point) => {
      if (point.value === null) {
        step = 'M';
        return '';
      }
      const place = `${step}${(PLOT_SECS + point.time - time).toFixed(2)} ${(19 - (18 * point.value) / most).toFixed(2)}`;
      step = 'L';
      return place;
    };
    path.setAttribute('d', points.map(draw).join(''));
    setText(now, format(value));
    setText(range, values.length ? `up to ${format(most)}` : '');
    setAttribute(svg, 'aria-label', `${name} in the last minute: ${range.textContent || 'none'}`);
  };
  return { node, add };
}

// A camera's image with hatching where masks and keep-out frames forbid light.
function makeScreen(name) {
  const image = make('canvas', { role: 'img', 'aria-label': `Image of ${name}`, width: 16, height: 10 });
  const hatching = make('canvas', { 'aria-hidden': 'true', width: 16, height: 10 });
  const caption = make('p', { class: 'caption' }, 'no image yet');
  const masked = make('p', { class: 'masked' });
  const node = make('div', { class: 'screen' }, image, hatching, caption, masked);
  const decode = (head, bytes) => createImageBitmap(new Blob([bytes], { type: `image/${head.format}` }));
  const imageContext = image.getContext('2d', { alpha: false });
  const hatchingContext = hatching.getContext('2d', { willReadFrequently: true });
  let hasImage = false;
  let dark = null;
  const tell = () => setText(caption, dark ?? (hasImage ? '' : 'no image yet'));

  async function showImage(head, bytes) {
    const bitmap = await decode(head, bytes);
    hasImage = true;
    tell();
    if (image.width !== bitmap.width || image.height !== bitmap.height) {
      image.width = bitmap.width;
      image.height = bitmap.height;
      node.style.setProperty('--ratio', bitmap.width / bitmap.height);
    }
    imageContext.drawImage(bitmap, 0, 0);
    bitmap.close();
  }

  async function showMask(head, bytes) {
    const bitmap = await decode(head, bytes);
    const scale = Math.min(1, MOST_MASK_PX / bitmap.width);
    hatching.width = Math.max(1, Math.round(bitmap.width * scale));
    hatching.height = Math.max(1, Math.round(bitmap.height * scale));
    const context = hatchingContext;
    context.drawImage(bitmap, 0, 0, hatching.width, hatching.height);
    bitmap.close();
    // 255 is all of the light, as in masks; the share that is missing becomes opacity, which the hatching then fills.
    const mask = context.getImageData(0, 0, hatching.width, hatching.height);
    let isMasked = false;
    for (let at = 0; at < mask.data.length; at += 4) {
      mask.data[at + 3] = 255 - mask.data[at];
      isMasked ||= mask.data[at] < 255;
    }
    context.putImageData(mask, 0, 0);
    context.globalCompositeOperation = 'source-in';
    context.fillStyle = context.createPattern(hatch(), 'repeat');
    context.fillRect(0, 0, hatching.width, hatching.height);
    setText(masked, isMasked ? 'hatched: no light' : '');
  }

  // What is there may be another run's.
  function clear() {
    hasImage = false;
    imageContext.clearRect(0, 0, image.width, image.height);
    hatchingContext.clearRect(0, 0, hatching.width, hatching.height);
    setText(masked, '');
    tell();
  }

  function update(camera) {
    dark = camera.dark;
    tell();
  }
  return { node, update, clear, image: showImage, mask: showMask };
}

// A tile of diagonal lines on a tint.
function hatch() {
  const tile = make('canvas', { width: 10, height: 10 });
  const context = tile.getContext('2d');
  context.fillStyle = '#ff525233';
  context.fillRect(0, 0, 10, 10);
  context.strokeStyle = '#ff8a80';
  context.lineWidth = 2;
  for (const start of [-10, 0, 10]) {
    context.moveTo(start - 1, 11);
    context.lineTo(start + 11, -1);
  }
  context.stroke();
  return tile;
}

// A camera: its image, figures, what is wrong, and the pad of its projector.
export function makeCamera({ name }) {
  const title = newId();
  const about = make('span');
  const onlyBlack = make('button', { type: 'button', onclick: () => black(onlyBlack, name) }, `Black ${name} only`);
  const onlyRelease = make('button', { type: 'button', onclick: (event) => release(event, onlyRelease, name) }, `Release ${name}`);
  const snapshot = make('button', { type: 'button', onclick: () => post('snapshot', { camera: name }, snapshot, 'Snapshot') });
  const screen = makeScreen(name);
  const plots = { rate_hz: makePlot('Rate', rate), latency_ms: makePlot('Latency', duration), age_ms: makePlot('Age', duration) };
  const figures = make('dl', { class: 'figures' }, ...Object.values(plots).map((plot) => plot.node));
  const statuses = makeStatuses();
  const nudge = makeNudge(name);
  const header = make('header', {}, make('h2', { id: title }, name), about, snapshot, onlyRelease, onlyBlack);
  const node = make('article', { class: 'camera', 'aria-labelledby': title },
    header, screen.node, figures, statuses.node, nudge.node);

  const update = (camera, state) => {
    const size = camera.size && `${camera.size.join(' × ')} ${camera.encoding}`;
    setText(about, [camera.topic, camera.frame && `frame ${camera.frame}`, size].filter(Boolean).join(', '));
    onlyRelease.hidden = !camera.blackout;
    onlyBlack.hidden = state.cameras.length < 2;
    setText(snapshot, state.cameras.length < 2 ? 'Snapshot' : `Snapshot of ${name}`);
    screen.update(camera);
    for (const [key, plot] of Object.entries(plots)) {
      plot.add(camera[key] ?? null);
    }
    statuses.show(camera.statuses.filter((status) => status.level !== 'ok' || status.name === 'Surface'));
    nudge.update(camera.nudge);
  };
  return { node, update, clear: screen.clear, image: screen.image, mask: screen.mask };
}
