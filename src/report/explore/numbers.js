"use strict";

// Arrays that the page carries, numbers in words, colours.

/** The array that a record of packed.rs holds. */
async function unpack({ law, bits, count, low, step, data }) {
  const packed = Uint8Array.from(atob(data), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  const top = 2 ** bits - 1;
  const values = new Float64Array(count);
  let code = 0;
  for (let i = 0; i < count; i++) {
    const change = bits === 16 ? bytes[i] + 256 * bytes[count + i] : bytes[i];
    code = (code + change) & top;
    if (law === "linear") values[i] = low + step * code;
    else values[i] = code === 0 ? 0 : low * Math.exp(step * (code - 1));
  }
  return values;
}

/** Colours of a palette, three bytes each. */
function paletteOf(hex) {
  return Uint8Array.from(hex.match(/../g), (byte) => parseInt(byte, 16));
}

/** Share of a palette, 0 to 1, of a value on a scale. */
function shareOf(value, { low, high, log }) {
  const share = log ? Math.log(Math.max(value, low) / low) / Math.log(high / low) : (value - low) / (high - low);
  return share > 0 ? Math.min(share, 1) : 0;
}

/** The power of ten that numbers of this size are told in; 0 where they are handy as they are. */
function exponentOf(size) {
  const exponent = size > 0 ? Math.floor(Math.log10(size)) : 0;
  return exponent < -1 || exponent > 3 ? exponent : 0;
}

/** A number with so many digits that count, without trailing exponents. */
function digits(value, count) {
  if (value === 0) return "0";
  // 0.996 in two digits is 1.0.
  const size = Math.abs(Number(value.toPrecision(count)));
  const decimals = Math.max(0, count - 1 - Math.floor(Math.log10(size)));
  return value.toFixed(Math.min(decimals, 12)).replace("-", "−");
}

/** The unit with a power of ten before it. */
function unitWith(exponent, unit) {
  const raised = [...String(exponent)].map((c) => (c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[c])).join("");
  return [exponent === 0 ? "" : "10" + raised, unit.replace("^2", "²")].filter(Boolean).join(" ");
}

/** Round places of ticks between two values, about `count` of them. */
function ticksOf(low, high, count) {
  const raw = (high - low) / count;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = power * [1, 2, 5, 10].find((digit) => digit * power >= raw * (1 - 1e-9));
  const ticks = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i++) ticks.push(i * step);
  return { ticks, decimals: Math.max(0, -Math.floor(Math.log10(step) + 1e-9)) };
}

/** The name of SVG's elements, as the page itself knows it. */
const SVG_SPACE = new DOMParser().parseFromString("<svg></svg>", "text/html").querySelector("svg").namespaceURI;

/** An element with attributes, in a parent. */
function add(parent, name, attributes = {}, text = "") {
  const isDrawn = name === "svg" || parent.namespaceURI === SVG_SPACE;
  const element = isDrawn ? document.createElementNS(SVG_SPACE, name) : document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  if (text) element.textContent = text;
  parent.append(element);
  return element;
}

/** A bar of colours with its ends and the unit in words. */
function colorBar(parent, { low, high, log, beyond }, palette, name, unit) {
  const bar = add(parent, "div", { class: "explore-bar" });
  const exponent = exponentOf(Math.max(Math.abs(low), Math.abs(high)));
  const said = (value) => digits(value / 10 ** exponent, 3);
  const colors = [];
  for (let i = 0; i < palette.length; i += 24) colors.push(`rgb(${palette.slice(i, i + 3).join(" ")})`);
  colors.push(`rgb(${palette.slice(-3).join(" ")})`);
  add(bar, "span", {}, (beyond && low !== 0 ? "≤ " : "") + said(low));
  add(bar, "i", { style: `background:linear-gradient(90deg,${colors.join(",")})` });
  add(bar, "span", {}, (beyond ? "≥ " : "") + said(high));
  const inUnit = unitWith(exponent, unit);
  add(bar, "span", {}, name + (inUnit ? ` (${inUnit})` : "") + (log ? ", logarithmic" : ""));
  return bar;
}
