"use strict";

// Links what can be looked at: one load, one place on the touched face.

/** All arrays of a record, unpacked. */
async function unpackedAll(record) {
  if (record === null || typeof record !== "object") return record;
  if ("data" in record && "law" in record) return unpack(record);
  const entries = Object.entries(record).map(async ([key, value]) => [key, await unpackedAll(value)]);
  const all = Object.fromEntries(await Promise.all(entries));
  return Array.isArray(record) ? Object.values(all) : all;
}

/** From pixels of the image to places in mm and back. */
function placeOf({ place, width, height, block }) {
  const size = [width * block, height * block];
  const middle = size.map((pixels) => pixels / 2);
  const table = place.radius_mm;
  function toRadius(pixels) {
    if (place.kind === "flat") return pixels * place.mm_per_pixel;
    const at = pixels / place.step_px;
    const i = Math.min(Math.floor(at), table.length - 2);
    return at > table.length - 1 + 1e-9 ? undefined : table[i] + (at - i) * (table[i + 1] - table[i]);
  }
  function toPixels(radius) {
    if (place.kind === "flat") return radius / place.mm_per_pixel;
    const next = table.findIndex((one) => one >= radius);
    if (next <= 0) return next === 0 ? 0 : undefined;
    return (next - 1 + (radius - table[next - 1]) / (table[next] - table[next - 1])) * place.step_px;
  }
  return {
    /** The place (x, y) of the middle of a pixel; nothing where total reflection hides it. */
    ofPixel(column, row) {
      const [u, v] = [(column + 0.5) * block - middle[0], middle[1] - (row + 0.5) * block];
      const pixels = Math.hypot(u, v);
      const radius = toRadius(pixels);
      if (radius === undefined) return undefined;
      return pixels === 0 ? [0, 0] : [(u * radius) / pixels, (v * radius) / pixels];
    },
    /** The pixel that sees a place; nothing outside of the image. */
    toPixel([x, y]) {
      const radius = Math.hypot(x, y);
      const pixels = toPixels(radius);
      if (pixels === undefined) return undefined;
      const scale = radius === 0 ? 0 : pixels / radius;
      const pixel = [middle[0] + x * scale, middle[1] - y * scale].map((at) => Math.floor(at / block));
      return pixel[0] >= 0 && pixel[0] < width && pixel[1] >= 0 && pixel[1] < height ? pixel : undefined;
    },
    /** Values' pixels that a distance from the middle takes. */
    radius: (mm) => (toPixels(mm) === undefined ? undefined : toPixels(mm) / block),
  };
}

/** A figure in the grid: its heading, the place of its picture, and where it is told what is pointed at. */
function panel(grid, title) {
  const figure = add(grid, "figure");
  const head = add(figure, "figcaption");
  add(head, "strong", {}, title);
  const note = add(head, "span");
  const host = add(figure, "div");
  return { figure, head, note, host, told: () => add(figure, "p", { class: "explore-told", "aria-live": "polite" }) };
}

const MM = (value) => value.toFixed(2).replace("-", "−");

/** A picture that tells its values; `linked` hears of each place, mm. */
function viewPanel(grid, view, palettes, loads, linked) {
  const { title, quantity, unit, error_is: errorIs, width, height, block, scale, noise, frames } = view;
  const { figure, note, host, told } = panel(grid, title);
  const palette = paletteOf(palettes[view.palette]);
  const places = placeOf(view);
  let frame = frames[frames.length - 1];
  let at = null;
  const picture = probe(host, {
    label: `${title}: arrow keys move from pixel to pixel, with the shift key by ten`,
    width,
    height,
    moved: (column, row) => {
      const place = column === undefined ? undefined : places.ofPixel(column, row);
      linked(place ?? null, { column, row }, api);
    },
  });
  const bar = colorBar(figure, scale, palette, quantity, unit);
  bar.setAttribute("aria-hidden", "true");
  const text = told();
  const exponent = unit ? exponentOf(scale.high) : 0;

  function errorOf(value, pixel) {
    if (frame.errors) return frame.errors[pixel];
    return noise ? Math.sqrt(noise.per_level * Math.max(value - noise.black, 0) + noise.floor) : undefined;
  }

  function tell() {
    text.textContent = at ? "" : "No pixel is pointed at.";
    if (!at) return;
    const [column, row] = at;
    const value = frame.values[row * width + column];
    const error = errorOf(value, row * width + column);
    const shown = (number, count) => digits(number / 10 ** exponent, count);
    const whole = !unit && Number.isInteger(value);
    add(text, "b", {}, whole ? String(value) : shown(value, 4));
    const inUnit = unitWith(exponent, unit);
    const one = block > 1 ? " of one pixel" : "";
    const mean = block > 1 ? `, mean of ${block} × ${block} pixels` : "";
    const plus = error === undefined ? "" : ` ± ${shown(error, 2)}`;
    text.append(`${plus}${inUnit ? " " + inUnit : ""}${plus && errorIs ? ` (${errorIs}${one})` : ""}${mean}`);
    add(text, "br");
    const place = places.ofPixel(column, row);
    const where = place
      ? `x ${MM(place[0])}, y ${MM(place[1])}, r ${MM(Math.hypot(...place))} mm`
      : "no place: total reflection";
    text.append(`${block > 1 ? "pixels from " : ""}column ${column * block}, row ${row * block}; ${where}`);
  }

  const api = {
    /** Shows the image of a load, or says of which one it is. */
    load(load) {
      const own = frames.find((one) => one.load === load);
      frame = own ?? frames[frames.length - 1];
      const alone = own || loads.length < 2 ? "" : `, traced at ${loads[frame.load].name} alone`;
      note.textContent = (frame.file || "") + alone;
      picture.paint(frame.values, scale, palette);
      tell();
    },
    /** Points at a pixel, or at the one that sees a place. */
    at(place, pixel) {
      at = pixel ? [pixel.column, pixel.row] : place ? places.toPixel(place) ?? null : null;
      picture.mark(...(at ?? []));
      tell();
    },
    ring: (mm) => picture.ring(mm === null ? undefined : places.radius(mm)),
  };
  return api;
}

/** Contact pressure along the radius; `linked` hears of each radius, mm. */
function curvePanel(grid, curves, loads, linked) {
  const { host, told } = panel(grid, "Contact pressure");
  const text = told();
  const [width, height, left, top, right, bottom] = [440, 300, 52, 12, 428, 252];
  host.classList.add("explore-picture", "explore-plot");
  const label = `contact pressure against the ${curves.along}: arrow keys move along the curve`;
  for (const [key, value] of Object.entries({ tabindex: 0, role: "application", "aria-label": label })) {
    host.setAttribute(key, value);
  }
  const svg = add(host, "svg", { viewBox: `0 0 ${width} ${height}`, "aria-hidden": "true" });
  const all = curves.loads.flat();
  const reach = Math.max(...all.map(([r]) => r), 1e-9);
  const least = Math.min(0, ...all.map(([, p]) => p));
  const low = Math.max(least, -0.2 * curves.highest_kpa);
  const most = curves.highest_kpa > 0 ? curves.highest_kpa : Math.max(...all.map(([, p]) => p), 1e-9);
  const x = (r) => left + (r / reach) * (right - left);
  const y = (p) => bottom - ((p - low) / (most - low)) * (bottom - top);
  const line = (d, look) => add(svg, "path", { d, fill: "none", ...look });
  const hair = { stroke: "var(--hair)" };
  for (const [from, to, count, axis] of [[0, reach, 6, "x"], [low, most, 5, "y"]]) {
    const { ticks, decimals } = ticksOf(from, to, count);
    for (const value of ticks) {
      const name = value.toFixed(decimals).replace("-", "−");
      if (axis === "x") {
        line(`M${x(value)} ${top}V${bottom}`, hair);
        add(svg, "text", { x: x(value), y: bottom + 18, "text-anchor": "middle" }, name);
      } else {
        line(`M${left} ${y(value)}H${right}`, hair);
        add(svg, "text", { x: left - 7, y: y(value) + 4.5, "text-anchor": "end" }, name);
      }
    }
  }
  line(`M${left} ${top}V${bottom}H${right}`, { stroke: "var(--ink)" });
  const middle = { class: "muted", "text-anchor": "middle" };
  add(svg, "text", { ...middle, x: (left + right) / 2, y: height - 8 }, `${curves.along} (mm)`);
  const [tx, ty] = [13, (top + bottom) / 2];
  add(svg, "text", { ...middle, x: tx, y: ty, transform: `rotate(-90 ${tx} ${ty})` }, "pressure (kPa)");
  const clip = add(svg, "svg", { x: left, y: top - 4, width: right - left + 4, height: bottom - top + 4,
    viewBox: `${left} ${top - 4} ${right - left + 4} ${bottom - top + 4}` });
  const paths = curves.loads.map((points) => {
    const d = points.map(([r, p], i) => `${i ? "L" : "M"}${x(r).toFixed(1)} ${y(p).toFixed(1)}`).join("");
    return add(clip, "path", { d, fill: "none", "stroke-linejoin": "round" });
  });
  const upright = line("", { stroke: "var(--ink)", "stroke-dasharray": "4 3" });
  const dot = add(clip, "circle", { r: 5, fill: "var(--accent)", stroke: "var(--card)", "stroke-width": 1.5 });
  let [load, at] = [0, null];

  /** Pressure at a distance, linear between nodes; nothing beyond them. */
  function pressureAt(r) {
    const points = curves.loads[load];
    const next = points.findIndex((point) => point[0] >= r);
    if (next < 0) return undefined;
    if (next === 0) return points[0][1];
    const [[r0, p0], [r1, p1]] = [points[next - 1], points[next]];
    return r1 > r0 ? p0 + ((r - r0) / (r1 - r0)) * (p1 - p0) : p1;
  }

  function tell() {
    text.textContent = at === null ? "No place is pointed at." : "";
    const pressure = at === null ? undefined : pressureAt(at);
    dot.setAttribute("visibility", pressure === undefined ? "hidden" : "visible");
    upright.setAttribute("d", at === null || at > reach ? "" : `M${x(at)} ${top}V${bottom}`);
    if (at === null) return;
    if (pressure === undefined) {
      text.textContent = `${MM(at)} mm: beyond the face that may touch`;
      return;
    }
    dot.setAttribute("cx", x(at));
    dot.setAttribute("cy", y(pressure));
    add(text, "b", {}, digits(pressure, 3));
    text.append(" kPa");
    add(text, "br");
    text.append(`at ${MM(at)} mm, pressed by ${loads[load].name}`);
  }

  const go = (r) => linked(Math.min(Math.max(r, 0), reach));
  const point = (event) => {
    const { left: from, width: across } = svg.getBoundingClientRect();
    const place = ((event.clientX - from) / across) * width;
    go(((place - left) / (right - left)) * reach);
  };
  host.addEventListener("pointermove", point);
  host.addEventListener("pointerdown", point);
  host.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (step) go((at ?? 0) + (step * (event.shiftKey ? 10 : 1) * reach) / 100);
    else if (event.key === "Escape") linked(null);
    else return;
    event.preventDefault();
  });

  return {
    load(chosen) {
      load = chosen;
      paths.forEach((path, i) => {
        path.setAttribute("stroke", i === chosen ? "var(--accent)" : "var(--muted)");
        path.setAttribute("stroke-width", i === chosen ? 2.5 : 1);
      });
      clip.append(paths[chosen], dot);
      tell();
    },
    at(r) {
      at = r;
      tell();
    },
  };
}

/** The deformed bodies, or the picture that the report has of them. */
function solidPanel(grid, solid, palettes) {
  const { figure, head, host, told } = panel(grid, "Deformed bodies");
  const label = "deformed bodies: arrow keys turn them, plus and minus zoom, 0 turns back";
  const shown = solidView(host, solid, label);
  if (!shown) {
    const picture = document.querySelector('img[alt^="deformed mesh"]');
    if (picture) add(host, "img", { src: picture.src, alt: picture.alt });
    told().textContent = "This browser has no WebGL 2, so the bodies do not turn.";
    return { load() {} };
  }
  const choice = add(head, "select", { "aria-label": "colour shows" });
  for (const name of ["pressure", "displacement"]) add(choice, "option", {}, name);
  const count = solid.loads[0].pressure_kpa.length;
  const lengths = solid.loads.map(({ moved }) =>
    Float64Array.from({ length: count }, (_, i) => {
      let square = 0;
      for (let k = i; k < moved.length; k += count) square += moved[k] ** 2;
      return Math.sqrt(square);
    }),
  );
  const [low, high] = solid.range_kpa;
  const longest = Math.max(...lengths.map((one) => one.reduce((a, b) => Math.max(a, b), 0)));
  const scales = {
    pressure: { low, high, beyond: true, name: "mean pressure", unit: "kPa", palette: low < 0 ? "signed" : "pressure" },
    displacement: { low: 0, high: longest, name: "displacement", unit: "mm", palette: "light" },
  };
  const bars = Object.values(scales).map((scale) =>
    colorBar(figure, scale, paletteOf(palettes[scale.palette]), scale.name, scale.unit),
  );
  told().textContent = "Drag to turn. After a click the wheel zooms, as do two fingers. Deformation to scale.";
  let load = 0;

  function paint() {
    const scale = scales[choice.value];
    bars.forEach((bar, i) => (bar.style.display = i === choice.selectedIndex ? "" : "none"));
    const values = choice.value === "pressure" ? solid.loads[load].pressure_kpa : lengths[load];
    shown.show(load, Float64Array.from(values, (value) => shareOf(value, scale)), paletteOf(palettes[scale.palette]));
  }

  choice.addEventListener("change", paint);
  return {
    load(chosen) {
      load = chosen;
      paint();
    },
  };
}

async function explore() {
  const packed = JSON.parse(document.getElementById("explore-data").textContent);
  const { loads, views, curves, solid, palettes } = await unpackedAll(packed);
  document.getElementById("explore").hidden = false;
  const grid = document.getElementById("explore-grid");
  const panels = [];
  let curve = null;

  /** A place of which no picture but a curve told has a radius alone. */
  function link(place, radius, pixel, from) {
    for (const view of panels) {
      view.at(place, view === from ? pixel : undefined);
      view.ring(place ? null : radius);
    }
    if (curve) curve.at(radius);
  }

  for (const view of views) {
    panels.push(viewPanel(grid, view, palettes, loads, (place, pixel, from) => {
      link(place, place ? Math.hypot(...place) : null, pixel.column === undefined ? undefined : pixel, from);
    }));
  }
  if (curves) curve = curvePanel(grid, curves, loads, (radius) => link(null, radius));
  const body = solid ? solidPanel(grid, solid, palettes) : null;

  function choose(load) {
    for (const one of [...panels, curve, body]) if (one) one.load(load);
    if (!loads.length) return;
    const { name, force_n: force, peak_pressure_kpa: peak } = loads[load];
    const figures = document.getElementById("explore-figures");
    figures.textContent = `${name}: force ${digits(force, 3)} N, peak pressure ${digits(peak, 3)} kPa`;
    document.getElementById("explore-slider").setAttribute("aria-valuetext", figures.textContent);
  }

  if (loads.length) {
    const slider = document.getElementById("explore-slider");
    [slider.max, slider.value] = [loads.length - 1, loads.length - 1];
    slider.hidden = loads.length < 2;
    slider.addEventListener("input", () => choose(Number(slider.value)));
    document.getElementById("explore-load").hidden = false;
  }
  choose(Math.max(loads.length - 1, 0));
}

if ("DecompressionStream" in window) explore();
