// Drawing: a queue so that the page stays responsive, redrawing on a change of theme, width or medium.

const figures = [];
let errorsSeen = 0;

const MODE_BAR = {
  displaylogo: false, responsive: false,
  // Without a pointer that hovers the buttons would stand over the figure for good.
  displayModeBar: window.matchMedia("(hover: hover)").matches ? "hover" : false,
  modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d", "toImage", "sendDataToCloud", "hoverClosestCartesian",
    "hoverCompareCartesian", "toggleSpikelines"],
};

// A figure is a box with controls, a plot and a caption. `build(width)` returns {data, layout, caption}
// from the present choices; `redraw()` runs it again. `kind` names it for tests and file names.
function figure(kind, label, controls, build, options) {
  const plot = h("div", { class: "chart", "data-figure": kind, role: "img", "aria-label": label });
  const caption = h("figcaption", {});
  const entry = { plot, kind, build, caption, options: options || {}, width: 0 };
  figures.push(entry);
  const save = h("button", { type: "button", class: "save", title: "Save this figure as SVG",
    onclick: () => Plotly.downloadImage(plot, { format: "svg", filename: `umov-${kind}`, width: plot.clientWidth,
      height: plot.clientHeight }) }, "Save SVG");
  entry.picture = entry.options.webgl ? h("img", { class: "for-print", alt: label }) : null;
  entry.node = h("figure", { class: entry.options.webgl ? "webgl" : null },
    h("div", { class: "controls" }, controls, save), plot, entry.picture, caption);
  entry.redraw = () => {
    drawFigure(entry);
    if (entry.picture) preparePicture(entry, 900);
  };
  return entry;
}

function drawFigure(entry) {
  const width = entry.plot.clientWidth;
  if (width < 40) return;
  entry.width = width;
  try {
    const { data, layout, caption } = entry.build(width);
    const config = Object.assign({}, MODE_BAR, { toImageButtonOptions: { format: "svg",
      filename: `umov-${entry.kind}` } });
    Plotly.react(entry.plot, data, Object.assign(baseLayout(), layout, { width }), config);
    entry.caption.replaceChildren(...[caption].flat().filter((part) => part !== null && part !== undefined));
    entry.plot.dataset.drawn = "yes";
  } catch (error) {
    errorsSeen += 1;
    entry.plot.replaceChildren(h("p", { class: "notice" }, `This figure could not be drawn: ${error.message}`));
    console.error(`figure ${entry.kind}: ${error.stack || error}`);
  }
}

// A WebGL canvas prints blank: a picture of it stands ready instead, made when nothing else is to do.
const PICTURE_WIDTH = 980;
function preparePicture(entry, delay) {
  clearTimeout(entry.waiting);
  if (!webglWorks()) return Promise.resolve();
  return new Promise((done) => {
    entry.waiting = setTimeout(() => {
      printing = true;
      const { data, layout } = entry.build(PICTURE_WIDTH);
      const whole = Object.assign(baseLayout(), layout, { width: PICTURE_WIDTH });
      printing = false;
      Plotly.toImage({ data, layout: whole }, { format: "png", width: PICTURE_WIDTH, height: whole.height, scale: 2 })
        .then((url) => { entry.picture.src = url; done(); })
        .catch((error) => { console.warn(`no picture for print: ${error}`); done(); });
    }, delay);
  });
}

function drawAllInTurn() {
  let next = 0;
  const step = () => {
    if (next < figures.length) {
      drawFigure(figures[next++]);
      setTimeout(step, 0);
    } else {
      document.documentElement.dataset.figures = String(figures.filter((f) => f.plot.dataset.drawn).length);
      document.documentElement.dataset.errors = String(errorsSeen);
      document.documentElement.dataset.ready = "yes";
      const solid = figures.filter((f) => f.picture);
      solid.reduce((before, f) => before.then(() => preparePicture(f, 50)), Promise.resolve())
        .then(() => { document.documentElement.dataset.printable = "yes"; });
    }
  };
  step();
}

function redrawAll(which) {
  applyTheme();
  paintSwatches();
  for (const entry of figures) if (entry.width && (!which || which(entry))) drawFigure(entry);
}

function watchSurroundings() {
  scheme.addEventListener("change", () => redrawAll());
  let pending = 0;
  window.addEventListener("resize", () => {
    clearTimeout(pending);
    pending = setTimeout(() => {
      for (const entry of figures) if (entry.width && entry.plot.clientWidth !== entry.width) drawFigure(entry);
    }, 120);
  });
  // On paper: light, and at the width of the text block, whatever the window was.
  window.addEventListener("beforeprint", () => {
    printing = true;
    for (const part of document.querySelectorAll("details:not([open])")) { part.open = true; part.dataset.closed = "yes"; }
    document.documentElement.classList.add("printing");
    redrawAll((entry) => !entry.picture);
  });
  window.addEventListener("afterprint", () => {
    printing = false;
    for (const part of document.querySelectorAll("details[data-closed]")) { part.open = false; delete part.dataset.closed; }
    document.documentElement.classList.remove("printing");
    redrawAll((entry) => !entry.picture);
  });
}

const FONT = 'system-ui, -apple-system, "Segoe UI", Roboto, "Noto Sans", "DejaVu Sans", sans-serif';

function baseLayout() {
  const p = palette();
  return {
    font: { family: FONT, size: 12.5, color: p.text },
    paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
    margin: { l: 66, r: 14, t: 34, b: 52 },
    hoverlabel: { font: { family: FONT, size: 12 }, namelength: -1 },
    showlegend: true,
    legend: { orientation: "h", x: 0, y: 1, xanchor: "left", yanchor: "bottom", font: { size: 12.5 },
      bgcolor: "rgba(0,0,0,0)" },
    modebar: { bgcolor: "rgba(0,0,0,0)", color: p.zero, activecolor: p.text },
    dragmode: "zoom",
  };
}

function axis(title, extra) {
  const p = palette();
  return Object.assign({
    title: title ? { text: title, standoff: 8, font: { size: 12.5, color: p.soft } } : undefined,
    gridcolor: p.line, zerolinecolor: p.zero, linecolor: p.zero, tickcolor: p.zero,
    showline: true, ticks: "outside", ticklen: 4, automargin: false, zeroline: false,
    tickfont: { size: 11.5, color: p.soft },
  }, extra || {});
}

// Powers of ten as 10⁻³; on less than two decades also 2 and 5.
function logAxis(title, low, high, extra) {
  const decades = Math.log10(high) - Math.log10(low);
  return axis(title, Object.assign({ type: "log", exponentformat: "power", dtick: decades > 1.6 ? 1 : "D2",
    range: [Math.log10(low), Math.log10(high)],
    minor: undefined }, extra || {}));
}

// Positions of n small panels in `columns` columns, in paper coordinates; room for titles between.
function panelGrid(n, width, rowHeight, margins) {
  const most = width > 820 ? 3 : width > 560 ? 2 : 1;
  // Four panels stand better as two by two than as three and a straggler.
  const columns = n === 4 ? Math.min(most, 2) : Math.min(n, most);
  const rows = Math.ceil(n / columns);
  const plotHeight = rows * rowHeight;
  const gapX = columns > 1 ? 26 / (width - margins.l - margins.r) : 0;
  const gapY = rows > 1 ? 72 / plotHeight : 0;
  const w = (1 - gapX * (columns - 1)) / columns;
  const tall = (1 - gapY * (rows - 1)) / rows;
  const cells = [];
  for (let i = 0; i < n; i++) {
    const column = i % columns;
    const row = Math.floor(i / columns);
    const top = 1 - row * (tall + gapY);
    cells.push({ x: [column * (w + gapX), column * (w + gapX) + w], y: [Math.max(0, top - tall), Math.min(1, top)],
      column, row, bottom: i + columns >= n });
  }
  return { cells, height: plotHeight + margins.t + margins.b, columns, rows };
}

// Two pictures, of which the second is a square with a colour bar at its right: side by side in a wide
// figure, one above the other in a narrow one. `firstHeight` is the first one's in pixels when stacked.
function pairOf(width, margin, firstHeight) {
  const wide = width > 760;
  const inner = width - margin.l - margin.r;
  if (wide) {
    const square = Math.min(430, 0.43 * inner);
    const height = square + margin.t + margin.b;
    const side = square / inner;
    return { wide, height, first: { x: [0, 1 - side - 60 / inner], y: [0, 1] }, second: { x: [1 - side, 1], y: [0, 1] },
      bar: { len: 0.78, y: 0.5 }, aspect: ((1 - side) * inner - 60) / square };
  }
  const gap = firstHeight ? 66 : 0;
  const total = firstHeight + gap + inner;
  const share = inner / total;
  return { wide, height: total + margin.t + margin.b, first: { x: [0, 1], y: [(inner + gap) / total, 1] },
    second: { x: [0, 1], y: [0, share] }, bar: { len: 0.8 * share, y: share / 2 },
      aspect: inner / (firstHeight || inner) };
}

const ANGLE_AXIS = "θ<sub>r</sub> / °  (− retro, + forward)";

function extent(values, keep) {
  let low = Infinity, high = -Infinity;
  for (const v of values) if (keep(v)) { if (v < low) low = v; if (v > high) high = v; }
  return [low, high];
}

function axisKey(letter, i) { return `${letter}axis${i === 0 ? "" : i + 1}`; }
function axisName(letter, i) { return `${letter}${i === 0 ? "" : i + 1}`; }

// An entry of the legend by itself, of a size that can be seen; the traces of its group stay out of it.
function legendEntry(name, marker, line) {
  return { type: "scatter", mode: line ? "lines+markers" : "markers", x: [null], y: [null], name, legendgroup: name,
    hoverinfo: "skip",
    marker: Object.assign({ size: 8 }, marker), line: line || undefined };
}

function webglWorks() {
  if (webglWorks.known === undefined) {
    try {
      const canvas = document.createElement("canvas");
      webglWorks.known = Boolean(canvas.getContext("webgl") || canvas.getContext("experimental-webgl"));
    } catch (error) {
      webglWorks.known = false;
    }
  }
  return webglWorks.known;
}
