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

function makeParameter(server, parameter) {
  const id = newId();
  const { box, set } = makeField(parameter, id, (value, source) => setParameters(server, { [parameter.name]: value }, source));
  const number = (value) => (typeof value === 'number' ? plain(value) : String(value));
  const isRange = box.min !== undefined && box.min !== '' && box.max !== '';
  const limits = [isRange && `${number(parameter.min)} to ${number(parameter.max)}`, `default ${number(parameter.default)}`];
  const about = make('small', { id: newId() }, `${parameter.description} (${limits.filter(Boolean).join('; ')})`);
  setAttribute(box, 'aria-describedby', about.id);
  const node = make('div', { class: 'parameter' }, make('label', { for: id }, parameter.name), box, about);
  return { node, update: (now) => set(now.value) };
}

// The form of a dynamic_reconfigure server.
export function makeServer({ name }) {
  const summary = make('summary');
  const list = make('div', { class: 'parameters' });
  // A parameter with other limits is another one.
  const key = ({ value, ...description }) => JSON.stringify(description);
  const views = new Views(list, key, (parameter) => makeParameter(name, parameter));
  const update = (server) => {
    setText(summary, server.camera ? `${server.camera} (${name})` : name);
    views.show(server.parameters);
  };
  return { node: make('details', {}, summary, list), update };
}
