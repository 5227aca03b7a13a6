'use strict';

// `told` is what the program says of the scene: name, description, knobs, colors.
const at = (id) => document.getElementById(id);
const token = new URLSearchParams(location.search).get('token');
const url = (path, more = {}) => `${path}?${new URLSearchParams({ token, ...more })}`;
const figure = (value, digits = 3) => Number(value.toPrecision(digits)).toString();

at('name').textContent = told.name;
at('description').textContent = told.description;
document.title = `tirtouch: ${told.name}`;
at('save').href = url('/scene.toml');

// ---- numbers ----

const changed = new Map();

/** The value rounded to a thousandth of its range: what a hand on a slider means. */
function rounded(knob, value) {
  if (knob.whole) return Math.round(value);
  const step = 10 ** Math.floor(Math.log10((knob.to - knob.from) / 1000));
  return Number((Math.round(value / step) * step).toPrecision(12));
}

function makeKnob(knob) {
  const row = document.createElement('div');
  row.className = 'knob';
  row.dataset.key = knob.key;
  const id = `knob-${knob.key}`;
  const label = Object.assign(document.createElement('label'), { htmlFor: id, textContent: knob.key });
  const range = Object.assign(document.createElement('input'), { type: 'range', id });
  Object.assign(range, { min: knob.from, max: knob.to, step: knob.whole ? 1 : 'any', value: knob.value });
  const number = Object.assign(document.createElement('input'), { type: 'number', value: knob.value });
  number.step = knob.whole ? 1 : 'any';
  number.setAttribute('aria-label', knob.key);
  const take = (value) => {
    if (!Number.isFinite(value)) return;
    if (value === knob.value) changed.delete(knob.key);
    else changed.set(knob.key, value);
    row.classList.toggle('changed', changed.has(knob.key));
    send();
  };
  range.addEventListener('input', () => {
    number.value = rounded(knob, range.valueAsNumber);
    take(number.valueAsNumber);
  });
  number.addEventListener('change', () => {
    range.value = number.value;
    take(number.valueAsNumber);
  });
  row.show = (value) => {
    range.value = number.value = value;
    row.classList.toggle('changed', value !== knob.value);
  };
  const pair = document.createElement('div');
  pair.append(range, number);
  row.append(label, pair);
  return row;
}

const rows = told.knobs.map(makeKnob);
rows.forEach((row, k) => at(told.knobs[k].first ? 'first' : 'others').append(row));
at('more').open = !told.knobs.some((knob) => knob.first);
at('filter').addEventListener('input', () => {
  const part = at('filter').value.toLowerCase();
  for (const row of at('others').children) row.hidden = !row.dataset.key.toLowerCase().includes(part);
});

/** Takes the numbers of a wish that another page made, or this one before it was loaded again. */
function adopt(values) {
  changed.clear();
  Object.entries(values).forEach(([key, value]) => changed.set(key, value));
  rows.forEach((row, k) => row.show(changed.get(row.dataset.key) ?? told.knobs[k].value));
}

at('reset').addEventListener('click', () => {
  adopt({});
  send();
});

let sending = false;
let waits = false;
let wished = 0;

/** Sends the numbers that were changed; while an answer is awaited only the latest are kept. */
async function send() {
  if (sending) {
    waits = true;
    return;
  }
  sending = true;
  do {
    waits = false;
    try {
      const answer = await fetch(url('/wish'), { method: 'POST', body: JSON.stringify(Object.fromEntries(changed)) });
      const text = await answer.text();
      const isJson = answer.headers.get('content-type') === 'application/json';
      const { wish, error } = isJson ? JSON.parse(text) : { error: { message: text } };
      at('refused').textContent = error ? [error.key, error.message].filter(Boolean).join(': ') : '';
      if (!error) wished = wish;
    } catch {
      at('refused').textContent = 'The program does not answer; this is tried again.';
      await new Promise((later) => { setTimeout(later, 1000); });
      waits = true;
    }
  } while (waits);
  sending = false;
}

// ---- the image ----

let picture = null;
let scale = null;
let probe = null;

function read(bytes) {
  const [width, height, top] = new Uint32Array(bytes, 0, 3);
  const count = width * height;
  const floats = 12 + 4 * Math.ceil(count / 2);
  return {
    width, height, top,
    grey: new Uint16Array(bytes, 12, count),
    mean: new Float32Array(bytes, floats, count),
    error: new Float32Array(bytes, floats + 4 * count, count),
  };
}

/** The top of the scale: what all but a thousandth of the pixels keep below. */
function topOf(shown) {
  const sorted = Float32Array.from(picture[shown]).sort();
  return sorted[Math.floor(0.999 * (sorted.length - 1))] || 1;
}

function draw() {
  if (!picture) return;
  const shown = at('show').value;
  const kept = at('hold').checked && scale && scale.shown === shown;
  if (!kept) scale = { shown, top: topOf(shown) };
  const canvas = at('image');
  if (canvas.width !== picture.width || canvas.height !== picture.height) {
    canvas.width = picture.width;
    canvas.height = picture.height;
  }
  const context = canvas.getContext('2d');
  const image = context.createImageData(picture.width, picture.height);
  const values = picture[shown];
  for (let k = 0; k < values.length; k += 1) {
    const level = Math.max(0, Math.min(255, Math.round((255 * values[k]) / scale.top)));
    const color = shown === 'grey' ? level * 0x010101 : parseInt(told.colors.substr(6 * level, 6), 16);
    image.data.set([color >> 16, (color >> 8) & 255, color & 255, 255], 4 * k);
  }
  context.putImageData(image, 0, 0);
  const unit = shown === 'grey' ? `of ${picture.top} grey levels` : 'W/(m² sr)';
  at('scale').textContent = `dark is 0, bright ${figure(scale.top)} ${unit}`;
  tellProbe();
}

function tellProbe() {
  at('cross').hidden = !probe || !picture;
  if (!probe || !picture) return;
  const { width, height, top, grey, mean, error } = picture;
  const column = Math.max(0, Math.min(width - 1, probe.column));
  const row = Math.max(0, Math.min(height - 1, probe.row));
  probe = { column, row };
  at('cross').style.left = `${(100 * (column + 0.5)) / width}%`;
  at('cross').style.top = `${(100 * (row + 0.5)) / height}%`;
  const k = row * width + column;
  const mm = picture.mm_per_pixel;
  const x = mm * (column + 0.5 - width / 2);
  const y = mm * (height / 2 - row - 0.5);
  at('probe').textContent = `column ${column}, row ${row} (x ${x.toFixed(2)} mm, y ${y.toFixed(2)} mm on the touched `
    + `face): grey level ${grey[k]} of ${top}, radiance ${figure(mean[k], 4)} ± ${figure(error[k], 2)} W/(m² sr)`;
}

function point(event) {
  if (!picture) return;
  const box = at('image').getBoundingClientRect();
  probe = {
    column: Math.floor(((event.clientX - box.left) / box.width) * picture.width),
    row: Math.floor(((event.clientY - box.top) / box.height) * picture.height),
  };
  tellProbe();
}

at('image').addEventListener('pointermove', point);
at('image').addEventListener('pointerdown', point);
at('image').addEventListener('keydown', (event) => {
  const moves = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
  const move = moves[event.key];
  if (!move || !picture) return;
  event.preventDefault();
  const from = probe || { column: picture.width >> 1, row: picture.height >> 1 };
  const far = event.shiftKey ? 10 : 1;
  probe = { column: from.column + far * move[0], row: from.row + far * move[1] };
  tellProbe();
});
at('show').addEventListener('change', draw);
at('hold').addEventListener('change', draw);

// ---- figures ----

function fill(table, rows) {
  const row = (cells) => {
    const line = document.createElement('tr');
    for (const cell of cells) {
      const place = document.createElement('td');
      place.append(cell);
      if (cell instanceof Node) place.className = 'bar';
      line.append(place);
    }
    return line;
  };
  at(table).tBodies[0].replaceChildren(...rows.map(row));
}

const undefinedOr = (value, say) => (value && value.undefined === undefined ? say(value) : 'undefined');

function tellFigures(said, estimates) {
  const { ledger, truth, camera } = said;
  const names = { absorbed: 'absorbed', escaped_top: 'escaped at the top', escaped_bottom: 'escaped at the bottom',
    escaped_sides: 'escaped at the sides', detected: 'detected', terminated: 'cut off' };
  const bar = (share) => {
    const bar = document.createElement('span');
    bar.style.width = `${100 * Math.max(0, Math.min(1, share))}%`;
    return bar;
  };
  fill('ledger', Object.entries(names).filter(([key]) => ledger[key] !== 0)
    .map(([key, name]) => [name, `${figure(100 * ledger[key])} %`, bar(ledger[key])]));
  fill('facts', [
    ['error of a lit pixel', undefinedOr({ value: said.relative_error }, ({ value }) => (
      typeof value === 'number' ? `${figure(100 * value)} %` : 'undefined: the image is dark'))],
    ['mean radiance', `${figure(said.mean_radiance)} W/(m² sr)`],
    ['brightest grey level', `${camera.max_grey} of ${camera.top_grey}`],
    ['paths a pixel', String(said.spp)],
    ['photons', figure(said.photons)],
    ['method', `${said.integrator}: ${said.why}`],
    ['adapter', said.adapter],
  ]);
  at('inclusion').hidden = typeof truth.size_mm !== 'number' && !estimates;
  const known = [['size', 'size_mm', 'mm'], ['depth to the top', 'depth_mm', 'mm'],
    ["Young's modulus", 'youngs_kpa', 'kPa']];
  fill('estimates', known.map(([name, key, unit]) => {
    const value = estimates && estimates[key];
    const isKnown = value && value.undefined === undefined;
    const real = typeof truth[key] === 'number' ? `${figure(truth[key])} ${unit}` : 'none';
    const span = isKnown ? `${figure(value.low)} to ${figure(value.high)} ${unit}` : '';
    return [name, real, isKnown ? `${figure(value.value)} ${unit}` : value ? 'undefined' : '…', span];
  }));
  const reasons = estimates ? known.map(([, key]) => estimates[key].undefined).filter(Boolean) : [];
  at('note').textContent = [...new Set(reasons)].join('; ');
}

// ---- news ----

let shown = '';

async function show(look) {
  const name = `${look.wish}/${look.step}`;
  if (name === shown) return;
  const [pixels, side] = await Promise.all([fetch(url('/pixels')), fetch(url('/side.svg'))]);
  if (!pixels.ok || !side.ok) return;
  picture = { ...read(await pixels.arrayBuffer()), mm_per_pixel: look.said.camera.mm_per_pixel };
  draw();
  const old = at('side').src;
  at('side').src = URL.createObjectURL(await side.blob());
  if (old) URL.revokeObjectURL(old);
  shown = name;
  document.body.dataset.shown = name;
}

function tellStatus(seen) {
  const isLast = seen.look && seen.look.wish === seen.wish && seen.look.is_last;
  const work = isLast ? 'the other loads, for the estimate' : `image ${seen.step} of ${seen.steps}`;
  at('status').textContent = seen.error
    || (seen.busy ? `${work}: ${seen.what}` : 'done: this is the image that render makes of the scene');
  at('status').style.color = seen.error ? 'var(--warn)' : '';
  at('done').value = seen.busy ? seen.done : 1;
  Object.assign(document.body.dataset, { wish: seen.wish, busy: seen.busy, wished });
}

async function follow() {
  for (let after = 0; ;) {
    try {
      const answer = await fetch(url('/seen', { after }));
      if (!answer.ok) throw new Error(await answer.text());
      const seen = await answer.json();
      after = seen.revision;
      if (!sending && seen.latest.wish > wished) {
        wished = seen.latest.wish;
        adopt(seen.latest.values);
      }
      if (seen.look) {
        await show(seen.look);
        tellFigures(seen.look.said, seen.estimates);
      }
      tellStatus(seen);
    } catch (error) {
      at('status').textContent = `The program does not answer: ${error.message}`;
      await new Promise((later) => { setTimeout(later, 1000); });
    }
  }
}

follow();
