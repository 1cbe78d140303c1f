"use strict";
// What the page does: theme, sorting, copying, hiding series, and the picture viewer. Plain code without a library; it runs from disk.

const all = (selector, within = document) => [...within.querySelectorAll(selector)];
const byId = (id) => document.getElementById(id);

// ---- Theme: the system's, light or dark --------------------------------------------------------------------------

const themes = ["system", "light", "dark"];
function setTheme(theme) {
  document.documentElement.style.colorScheme = theme === "system" ? "light dark" : theme;
  byId("theme").textContent = `Theme: ${theme}`;
  byId("theme").dataset.theme = theme;
}
byId("theme").addEventListener("click", () => {
  const next = themes[(themes.indexOf(byId("theme").dataset.theme ?? "system") + 1) % themes.length];
  setTheme(next);
});

// ---- Tables: a click on a head sorts, another one reverses -------------------------------------------------------

for (const button of all("button.sort")) {
  button.addEventListener("click", () => {
    const head = button.closest("th");
    const descending = head.getAttribute("aria-sort") === "ascending";
    for (const other of head.parentElement.children) other.setAttribute("aria-sort", "none");
    head.setAttribute("aria-sort", descending ? "descending" : "ascending");
    const column = head.cellIndex;
    const numbers = head.classList.contains("number");
    const key = (row) => {
      const cell = row.cells[column];
      if (!numbers) return cell.textContent.trim();
      return cell.dataset.sort === undefined ? null : Number(cell.dataset.sort);
    };
    const sign = descending ? -1 : 1;
    const body = head.closest("table").tBodies[0];
    const rows = [...body.rows].map((row) => [key(row), row]);
    rows.sort(([a], [b]) => {
      // What has no number is last in both directions.
      if (a === null || b === null) return (a === null) - (b === null);
      return sign * (numbers ? a - b : a.localeCompare(b, "en", { numeric: true }));
    });
    body.append(...rows.map(([, row]) => row));
  });
}

// ---- Commands ------------------------------------------------------------------------------------------------------

for (const button of all("button.copy")) {
  button.addEventListener("click", async () => {
    const code = button.parentElement.querySelector("code");
    let copied = true;
    try {
      await navigator.clipboard.writeText(code.textContent);
    } catch {
      // Browsers may refuse the clipboard to files: the text is selected, so that Ctrl+C copies it.
      getSelection().selectAllChildren(code);
      copied = false;
    }
    byId("status").textContent = copied ? "Copied" : "Selected; copy with Ctrl+C";
    button.textContent = copied ? "Copied" : "Selected";
    setTimeout(() => (button.textContent = "Copy"), 1500);
  });
}

// ---- Figures: the button of a series hides it ----------------------------------------------------------------------

for (const button of all("button.series")) {
  button.addEventListener("click", () => {
    const shown = button.getAttribute("aria-pressed") !== "true";
    button.setAttribute("aria-pressed", shown);
    const color = button.dataset.color;
    const panels = button.closest("figure").querySelector(".panels");
    for (const part of all(`[stroke="${color}"], [fill="${color}"]`, panels)) part.style.display = shown ? "" : "none";
  });
}

// ---- Picture viewer --------------------------------------------------------------------------------------------------

function viewer() {
  const data = JSON.parse(byId("data").textContent);
  const stage = byId("stage");
  const choices = { a: byId("picture-a"), b: byId("picture-b") };
  const largest = 32;
  // Zoom, and where the corner of the pictures is, in widths and heights of a pane: one state for both pictures.
  let zoom = 1, x = 0, y = 0;
  let mode = "slider", errors = false, second = false;

  const view = () => data.views[Number(byId("view").value)];

  function place() {
    x = Math.min(0, Math.max(1 - zoom, x));
    y = Math.min(0, Math.max(1 - zoom, y));
    stage.style.setProperty("--zoom", zoom);
    stage.style.setProperty("--x", x);
    stage.style.setProperty("--y", y);
    stage.classList.toggle("zoomed", zoom > 1);
    byId("zoom").textContent = `${Math.round(100 * zoom)} %`;
    for (const image of all("img", stage)) {
      // Pixels stay sharp squares once they are larger than those of the screen.
      image.classList.toggle("enlarged", image.clientWidth * zoom >= 1.5 * image.naturalWidth);
    }
  }

  // Zooms about a point of a pane, by default its middle.
  function zoomBy(factor, atX = 0.5, atY = 0.5) {
    const next = Math.min(largest, Math.max(1, zoom * factor));
    x = atX - (atX - x) * (next / zoom);
    y = atY - (atY - y) * (next / zoom);
    zoom = next;
    place();
  }

  function show() {
    for (const side of ["a", "b"]) {
      const picture = view().pictures[Number(choices[side].value)];
      const error = errors && picture.error !== null;
      const image = byId(`image-${side}`);
      image.src = data.images[error ? picture.error : picture.picture];
      const what = picture.name + (error ? ", error" : "");
      image.alt = `${view().name}: ${what}`;
      image.nextElementSibling.textContent = `${side.toUpperCase()}: ${what}`;
      byId(`name-${side}`).textContent = `${side.toUpperCase()}: ${picture.name}`;
      byId(`values-${side}`).textContent = picture.values.length ? picture.values.join(", ") : "ground truth";
    }
    stage.className = mode;
    stage.classList.toggle("second", second);
    for (const button of all("button[data-mode]")) button.setAttribute("aria-pressed", button.dataset.mode === mode);
    byId("error").setAttribute("aria-pressed", errors);
    byId("error").disabled = !view().pictures.some((picture) => picture.error !== null);
    byId("split-label").hidden = mode !== "slider";
    byId("flip").hidden = mode !== "flip";
    byId("flip").textContent = second ? "Show A" : "Show B";
    place();
  }

  // Another view: the variants that were chosen stay chosen where it has them.
  function choose(names) {
    const pictures = view().pictures;
    for (const [side, name] of Object.entries(names)) {
      choices[side].replaceChildren(...pictures.map((picture, index) => new Option(picture.name, index)));
      choices[side].value = Math.max(0, pictures.findIndex((picture) => picture.name === name));
    }
    show();
  }

  const nameOf = (side) => choices[side].selectedOptions[0]?.textContent;
  function setMode(next) {
    mode = next;
    second = false;
    show();
  }
  function flip() {
    if (mode !== "flip") setMode("flip");
    second = !second;
    show();
  }

  byId("view").addEventListener("change", () => choose({ a: nameOf("a"), b: nameOf("b") }));
  for (const choice of Object.values(choices)) choice.addEventListener("change", show);
  for (const button of all("button[data-mode]")) button.addEventListener("click", () => setMode(button.dataset.mode));
  byId("error").addEventListener("click", () => { errors = !errors; show(); });
  byId("flip").addEventListener("click", flip);
  byId("split").addEventListener("input", (event) => stage.style.setProperty("--split", `${event.target.value}%`));
  byId("zoom-in").addEventListener("click", () => zoomBy(2));
  byId("zoom-out").addEventListener("click", () => zoomBy(0.5));
  byId("zoom-reset").addEventListener("click", () => zoomBy(0));

  // Where an event is, in widths and heights of its pane.
  function within(event) {
    const right = mode === "side" && event.clientX > byId("pane-b").getBoundingClientRect().left;
    const box = byId(right ? "pane-b" : "pane-a").getBoundingClientRect();
    return [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height, box];
  }
  stage.addEventListener("wheel", (event) => {
    // The wheel scrolls the page until the picture has the focus.
    if (document.activeElement !== stage) return;
    event.preventDefault();
    const [atX, atY] = within(event);
    zoomBy(2 ** (-event.deltaY / 240), atX, atY);
  }, { passive: false });
  let from = [0, 0];
  stage.addEventListener("pointerdown", (event) => {
    stage.setPointerCapture(event.pointerId);
    from = [event.clientX, event.clientY];
  });
  stage.addEventListener("pointermove", (event) => {
    if (!stage.hasPointerCapture(event.pointerId)) return;
    const box = within(event)[2];
    x += (event.clientX - from[0]) / box.width;
    y += (event.clientY - from[1]) / box.height;
    from = [event.clientX, event.clientY];
    place();
  });
  stage.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const step = 0.1;
    const keys = {
      ArrowLeft: () => (x += step), ArrowRight: () => (x -= step), ArrowUp: () => (y += step), ArrowDown: () => (y -= step),
      "+": () => zoomBy(2), "=": () => zoomBy(2), "-": () => zoomBy(0.5), 0: () => zoomBy(0), f: flip, F: flip,
    };
    if (!keys[event.key]) return;
    event.preventDefault();
    keys[event.key]();
    place();
  });
  for (const image of all("img", stage)) image.addEventListener("load", place);
  addEventListener("resize", place);

  const first = data.views[0].pictures;
  choose({ a: first[data.first].name, b: first[data.first === 0 ? Math.min(1, first.length - 1) : 0].name });
}
if (byId("data")) viewer();
