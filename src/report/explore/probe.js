"use strict";

// A picture whose pixels can be pointed at.

/**
 * Makes an element show an image and tell which pixel is pointed at, by a pointer or by the arrow keys.
 *
 * `host` is an empty element; `label` is its name for screen readers; `width` and `height` count pixels; `moved(column,
 * row)` is called with each pixel pointed at, and with nothing when none is any more.
 *
 * Gives `paint(values, scale, palette)`: values row by row, a scale as `shareOf` takes it, a palette as `paletteOf`
 * gives it; `mark(column, row)`: puts the cross there, or takes it away; `ring(radius)`: draws a circle about the
 * middle, in pixels, or takes it away.
 */
function probe(host, { label, width, height, moved }) {
  host.classList.add("explore-picture");
  for (const [key, value] of Object.entries({ tabindex: 0, role: "application", "aria-label": label })) {
    host.setAttribute(key, value);
  }
  const canvas = add(host, "canvas", { width, height });
  const over = add(host, "svg", { viewBox: `0 0 ${width} ${height}`, "aria-hidden": "true" });
  // A light line in a dark one is seen on every colour.
  const looks = [
    { stroke: "#000", "stroke-width": 3.4, "stroke-opacity": 0.6 },
    { stroke: "#fff", "stroke-width": 1.4 },
  ].map((look) => ({ fill: "none", "vector-effect": "non-scaling-stroke", ...look }));
  const crosses = looks.map((look) => add(over, "path", look));
  const middle = { cx: width / 2, cy: height / 2, visibility: "hidden" };
  const rings = looks.map((look) => add(over, "circle", { ...middle, ...look }));
  let at = null;

  function mark(column, row) {
    at = column === undefined ? null : [column, row];
    const [x, y, arm] = at ? [column + 0.5, row + 0.5, width / 40] : [];
    const cross = `M${x - arm} ${y}H${x - arm / 3}M${x + arm / 3} ${y}H${x + arm}`;
    const upright = `M${x} ${y - arm}V${y - arm / 3}M${x} ${y + arm / 3}V${y + arm}`;
    for (const path of crosses) path.setAttribute("d", at ? cross + upright : "");
  }

  function ring(radius) {
    for (const one of rings) {
      one.setAttribute("visibility", radius === undefined ? "hidden" : "visible");
      if (radius !== undefined) one.setAttribute("r", radius);
    }
  }

  function go(column, row) {
    const inside = (place, count) => Math.min(Math.max(place, 0), count - 1);
    mark(inside(column, width), inside(row, height));
    moved(...at);
  }

  function point(event) {
    const { left, top, width: across, height: down } = canvas.getBoundingClientRect();
    const share = [(event.clientX - left) / across, (event.clientY - top) / down];
    go(Math.floor(share[0] * width), Math.floor(share[1] * height));
  }

  host.addEventListener("pointermove", point);
  host.addEventListener("pointerdown", point);
  host.addEventListener("keydown", (event) => {
    const step = event.shiftKey ? 10 : 1;
    const way = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, -step], ArrowDown: [0, step] }[event.key];
    if (way) {
      const [column, row] = at ?? [Math.floor(width / 2), Math.floor(height / 2)];
      go(column + (at ? way[0] : 0), row + (at ? way[1] : 0));
    } else if (event.key === "Escape") {
      mark();
      moved();
    } else {
      return;
    }
    event.preventDefault();
  });

  function paint(values, scale, palette) {
    const image = new ImageData(width, height);
    const last = palette.length / 3 - 1;
    for (let i = 0; i < values.length; i++) {
      const color = 3 * Math.round(shareOf(values[i], scale) * last);
      for (let k = 0; k < 3; k++) image.data[4 * i + k] = palette[color + k];
      image.data[4 * i + 3] = 255;
    }
    canvas.getContext("2d").putImageData(image, 0, 0);
  }

  return { paint, mark, ring };
}
