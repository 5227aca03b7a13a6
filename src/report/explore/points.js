"use strict";

// The points of a sweep, two side by side: figures, and images that lie beside the page.

/** Rows of the points by a column, or by their row in the design; what has no number comes last. */
function ordered(points, column) {
  const number = ({ row, values }) => (column === undefined ? row : parseFloat(values[column]));
  const known = (point) => (Number.isNaN(number(point)) ? 1 : 0);
  return [...points].sort((a, b) => known(a) - known(b) || number(a) - number(b) || a.row - b.row);
}

/** A slider over the points with the images of the chosen one; `chosen` hears of each. */
function pointPanel(grid, name, count, chosen) {
  const figure = add(grid, "figure");
  const head = add(figure, "div", { class: "explore-load points-choice" });
  const id = `points-${name}`;
  add(head, "label", { for: id }, name);
  const slider = add(head, "input", { type: "range", id, min: 0, max: count - 1, step: 1 });
  const output = add(head, "output", { for: id });
  const images = add(figure, "div", { class: "points-images" });
  slider.addEventListener("input", () => chosen(slider.valueAsNumber));

  function image([file, load], row) {
    const one = add(images, "figure");
    const shown = add(one, "img", { src: file, alt: `camera, row ${row}${load ? ", " + load : ""}` });
    const caption = add(one, "figcaption", {}, [load, file].filter(Boolean).join(": "));
    // The page alone, without its folder.
    shown.addEventListener("error", () => {
      shown.remove();
      caption.append(" (not beside this page)");
    });
  }

  return {
    show(place, { row, images: files }) {
      slider.value = place;
      output.textContent = `row ${row}`;
      slider.setAttribute("aria-valuetext", output.textContent);
      images.replaceChildren();
      files.forEach((file) => image(file, row));
    },
  };
}

function points() {
  const { names, along, points: all } = JSON.parse(document.getElementById("points-data").textContent);
  if (all.length < 2) return;
  const by = document.getElementById("points-by");
  add(by, "option", { value: "" }, "the design");
  names.forEach((name, column) => add(by, "option", { value: column }, name));
  if (along !== null) by.value = along;

  const table = document.getElementById("points-table");
  const heads = ["A", "B"].map((name) => add(table.tHead.rows[0], "th", { scope: "col", class: "number" }, name));
  const cells = names.map((name) => {
    const line = add(table.tBodies[0], "tr");
    add(line, "th", { scope: "row" }, name);
    return heads.map(() => add(line, "td", { class: "number" }));
  });

  let order = all;
  const chosen = [all[0], all[all.length - 1]];
  const choose = (which) => (place) => {
    chosen[which] = order[place];
    show();
  };
  const grid = document.getElementById("points-chosen");
  const panels = ["A", "B"].map((name, which) => pointPanel(grid, name, all.length, choose(which)));

  function show() {
    panels.forEach((panel, which) => panel.show(order.indexOf(chosen[which]), chosen[which]));
    heads.forEach((head, which) => (head.textContent = `${"AB"[which]}: row ${chosen[which].row}`));
    cells.forEach((line, column) => line.forEach((cell, which) => (cell.textContent = chosen[which].values[column])));
  }

  function arrange() {
    order = ordered(all, by.value === "" ? undefined : Number(by.value));
  }
  by.addEventListener("input", () => {
    arrange();
    show();
  });
  arrange();
  [chosen[0], chosen[1]] = [order[0], order[order.length - 1]];
  show();
  document.getElementById("points").hidden = false;
}

/** Lets a table be put in the order of a column, either way; what has no number stands last. */
function sortable(table) {
  const [head] = table.tHead.rows;
  const body = table.tBodies[0];
  function sort(column) {
    const cell = head.cells[column];
    const way = cell.ariaSort === "ascending" ? -1 : 1;
    for (const other of head.cells) other.ariaSort = other === cell ? (way > 0 ? "ascending" : "descending") : null;
    const text = (line) => line.cells[column].textContent;
    const value = (line) => parseFloat(text(line));
    const unknown = (line) => Number(Number.isNaN(value(line)));
    const compare = (a, b) =>
      unknown(a) - unknown(b) || way * (unknown(a) ? text(a).localeCompare(text(b)) : value(a) - value(b));
    body.append(...[...body.rows].sort(compare));
  }
  [...head.cells].forEach((cell, column) => {
    const name = cell.textContent;
    cell.replaceChildren();
    add(cell, "button", { type: "button", class: "sort" }, name).addEventListener("click", () => sort(column));
  });
}

points();
// The tables stand below.
document.addEventListener("DOMContentLoaded", () => {
  for (const table of document.querySelectorAll(".scroll>table")) if (table.tHead) sortable(table);
});
