// Points, turns and chooses as a reader would, and writes down what the page says then. `asked` is put before it.
async function look() {
  const wait = (ms) => new Promise((done) => setTimeout(done, ms));
  for (let i = 0; i < 400 && document.getElementById("explore").hidden; i++) await wait(25);
  const figures = [...document.querySelectorAll("#explore-grid figure")];
  const panel = (title) => figures.find((one) => one.querySelector("strong").textContent === title);
  const told = (title) => panel(title)?.querySelector(".explore-told").innerText ?? "";
  const host = (title) => panel(title).querySelector("[tabindex]");
  const send = (target, kind, at, more = {}) =>
    target.dispatchEvent(new PointerEvent(kind, { ...at, bubbles: true, cancelable: true, pointerId: 1, ...more }));
  const within = (element, x, y) => {
    const { left, top, width, height } = element.getBoundingClientRect();
    return { clientX: left + x * width, clientY: top + y * height };
  };
  const key = (target, key) => target.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true }));
  const point = (title, [column, row]) => {
    const canvas = host(title).querySelector("canvas");
    const at = within(canvas, (column + 0.5) / canvas.width, (row + 0.5) / canvas.height);
    send(canvas, "pointermove", at);
    return told(title);
  };
  const color = (title, [column, row]) => {
    const { data } = host(title).querySelector("canvas").getContext("2d").getImageData(column, row, 1, 1);
    return [...data].slice(0, 3);
  };
  const said = { titles: figures.map((one) => one.querySelector("strong").textContent), loads: [] };
  said.hidden = document.getElementById("explore").hidden;
  said.wide = document.documentElement.scrollWidth;
  const slider = document.getElementById("explore-slider");
  const body = host("Deformed bodies");
  const bodies = () => body?.querySelector("canvas")?.toDataURL() ?? "";
  said.picture = panel("Deformed bodies").querySelector("img")?.src.length ?? 0;

  said.first = slider.value;
  said.most = slider.max;
  for (const load of asked.loads) {
    slider.value = load;
    slider.dispatchEvent(new Event("input", { bubbles: true }));
    await wait(50);
    said.loads.push({
      figures: document.getElementById("explore-figures").innerText,
      file: panel("Camera").querySelector("figcaption span").innerText,
      alone: panel("Radiance").querySelector("figcaption span").innerText,
      camera: asked.pixels.map((pixel) => point("Camera", pixel)),
      colors: asked.pixels.map((pixel) => color("Camera", pixel)),
      radiance: asked.pixels.map((pixel) => point("Radiance", pixel)),
      linked: told("Camera"),
      curve: told("Contact pressure"),
      body: bodies(),
    });
  }

  // From the curve to the pictures: a circle.
  const plot = host("Contact pressure").querySelector("svg");
  send(plot, "pointermove", within(plot, 0.4, 0.5));
  said.along = told("Contact pressure");
  const ring = host("Radiance").querySelector("circle");
  said.ring = [ring.getAttribute("visibility"), Number(ring.getAttribute("r"))];

  // By keys.
  const picture = host("Radiance");
  picture.focus();
  point("Radiance", asked.pixels[0]);
  for (const one of ["ArrowRight", "ArrowDown"]) key(picture, one);
  said.keys = told("Radiance");
  key(picture, "Escape");
  said.escaped = told("Radiance");

  if (body) {
    said.turns = [body.dataset.view];
    const at = within(body, 0.5, 0.5);
    send(body, "pointerdown", at);
    send(body, "pointermove", { clientX: at.clientX + 40, clientY: at.clientY });
    send(body, "pointerup", at);
    said.turns.push(body.dataset.view);
    const wheel = () => body.dispatchEvent(new WheelEvent("wheel", { deltaY: -200, bubbles: true, cancelable: true }));
    wheel();
    said.turns.push(body.dataset.view);
    body.focus();
    wheel();
    said.turns.push(body.dataset.view);
    key(body, "0");
    said.turns.push(body.dataset.view);
    const choice = panel("Deformed bodies").querySelector("select");
    said.pressure = bodies();
    choice.value = "displacement";
    choice.dispatchEvent(new Event("change"));
    said.displacement = bodies();
  }
  said.faults = faults;
  const text = JSON.stringify(said);
  const out = document.createElement("pre");
  out.id = "said";
  out.textContent = btoa(unescape(encodeURIComponent(text)));
  document.body.append(out);
}
look().catch((fault) => {
  faults.push(String(fault.stack));
  const out = document.createElement("pre");
  out.id = "said";
  out.textContent = btoa(unescape(encodeURIComponent(JSON.stringify({ faults }))));
  document.body.append(out);
});
