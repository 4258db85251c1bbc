// dynamic_reconfigure: a form for each of its servers.

import { Views, make, makeSwitch, newId, plain, setAttribute, setText } from './elements.js';
import { setParameters } from './node.js';

// The element and the setter of a parameter; `onChange` gets a value of its type.
function makeField(parameter, id, onChange) {
  if (parameter.type === 'bool') {
    return makeSwitch({ id }, onChange);
  }
  const isNumber = parameter.type === 'int' || parameter.type === 'double';
  const read = () => (isNumber ? Number(box.value) : box.value);
  let box;
  if (parameter.choices?.length) {
    const option = ({ name, value, description }) => make('option', { value, title: description ?? '' }, name);
    box = make('select', { id }, ...parameter.choices.map(option));
  } else if (isNumber) {
    box = make('input', { id, type: 'number', step: parameter.type === 'int' ? 1 : 'any' });
    for (const end of ['min', 'max']) {
      if (Number.isFinite(parameter[end]) && Math.abs(parameter[end]) < 1e9) {
        box.setAttribute(end, parameter[end]);
      }
    }
  } else {
    box = make('input', { id, type: 'text' });
  }
  // What is being typed stays until it is sent.
  let isEdited = false;
  box.addEventListener('input', () => { isEdited = true; });
  box.addEventListener('change', async () => {
    if (box.value !== '' || !isNumber) {
      await onChange(read(), box);
    }
    isEdited = false;
  });
  const set = (value) => {
    const text = isNumber && !parameter.choices?.length ? plain(value) : String(value);
    if (!isEdited && box.value !== text) {
      box.value = text;
    }
  };
  return { box, set };
}

// `labelOf` is what the field is called.
function makeParameter(server, parameter, labelOf) {
  const id = newId();
  const { box, set } = makeField(parameter, id, (value, source) => setParameters(server, { [parameter.name]: value }, source));
  const number = (value) => (typeof value === 'number' ? plain(value) : String(value));
  const isRange = box.min !== undefined && box.min !== '' && box.max !== '';
  const limits = [isRange && `${number(parameter.min)} to ${number(parameter.max)}`, `default ${number(parameter.default)}`];
  const about = make('small', { id: newId() }, `${parameter.description} (${limits.filter(Boolean).join('; ')})`);
  setAttribute(box, 'aria-describedby', about.id);
  const node = make('div', { class: 'parameter' }, make('label', { for: id }, labelOf(parameter)), box, about);
  return { node, update: (now) => set(now.value) };
}

const withUnit = ({ label, unit }) => (unit ? `${label} [${unit}]` : label);

// The form of a dynamic_reconfigure server: its settings with names and units, and all of its parameters as it has them.
export function makeServer({ name }) {
  const title = make('h3');
  const advanced = make('summary');
  // A parameter with other limits is another one.
  const key = ({ value, ...description }) => JSON.stringify(description);
  const makeList = (labelOf) => {
    const list = make('div', { class: 'parameters' });
    return [list, new Views(list, key, (parameter) => makeParameter(name, parameter, labelOf))];
  };
  const [named, namedViews] = makeList(withUnit);
  const [raw, rawViews] = makeList((parameter) => parameter.name);
  const update = (server, { cameras }) => {
    const isOwn = cameras.some((camera) => camera.parameters === name);
    setText(title, isOwn ? server.camera : `${server.camera}, compressed images`);
    setText(advanced, `Advanced: ${name}`);
    namedViews.show(server.parameters.filter(({ label }) => label));
    rawViews.show(server.parameters);
  };
  return { node: make('div', { class: 'server' }, title, named, make('details', {}, advanced, raw)), update };
}
