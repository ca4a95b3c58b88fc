// Small builders. Text always goes in as text nodes: no string of the data is ever read as markup.

function h(tag, attributes, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes || {})) {
    if (value === null || value === undefined || value === false) continue;
    if (name === "class") node.className = value;
    else if (name.startsWith("on")) node.addEventListener(name.slice(2), value);
    else node.setAttribute(name, value === true ? "" : value);
  }
  for (const child of children.flat(3)) {
    if (child === null || child === undefined || child === false) continue;
    node.append(child instanceof Node ? child : document.createTextNode(String(child)));
  }
  return node;
}

// Names of parameters as they stand in the formulas: stem and subscript. Others keep their names.
const SYMBOLS_OF = {
  n: ["n"], kappa: ["κ"], sigma_um: ["σ"], tau_um: ["τ"], k_dd: ["k", "dd"], k_uds: ["k", "uds"], k_udf: ["k", "udf"],
    k_fs: ["k", "fs"],
  fs_width_deg: ["w"], fs_polarization: ["a"], rho: ["ρ"], rho_d1: ["ρ", "d1"], rho_d2: ["ρ", "d2"],
    slope_rms: ["σ", "s"], bias: ["B"],
  slope_2sigma_over_tau: ["2σ/τ"], alpha: ["α"], alpha_x: ["α", "x"], alpha_y: ["α", "y"], ks: ["k", "s"], omega: ["Ω"],
    tau: ["τ"],
};

// In a sum "1.rho" is ρ of the second part.
function symbol(name) {
  const terms = name.split("+").map((term) => {
    const [, part, stem] = /^(?:(\d+)\.)?(.*)$/.exec(term);
    const known = SYMBOLS_OF[stem];
    if (!known) return null;
    const below = [known[1], part].filter((s) => s !== undefined).join(",");
    return [h("i", {}, known[0]), below ? h("sub", {}, below) : null];
  });
  if (terms.some((t) => t === null)) return document.createTextNode(name.replaceAll("_", " "));
  return h("span", { class: "symbol", title: name }, terms.map((t, i) => [i ? " + " : "", t]));
}

// A table of strings. columns: [{title, align, wavelength}], rows: arrays of strings or nodes.
function table(columns, rows, options) {
  const settings = options || {};
  const head = columns.map((c) => h("th", { scope: "col", class: c.align === "left" ? "left" : null },
    c.wavelength_nm ? wavelengthLabel(c.wavelength_nm) : c.title));
  const body = rows.map((row) => h("tr", {}, row.map((cell, i) => {
    const left = columns[i].align === "left";
    if (i === 0) return h("th", { scope: "row", class: left ? "left" : null }, cell);
    return h("td", { class: left ? "left" : null }, cell);
  })));
  return h("div", { class: "table-scroll" + (settings.wide ? " wide" : "") },
    h("table", { class: settings.class || null },
      settings.caption ? h("caption", {}, settings.caption) : null,
      h("thead", {}, h("tr", {}, head)), h("tbody", {}, body)));
}

function wavelengthLabel(nm) {
  return h("span", { class: "wavelength" }, h("span", { class: "swatch", "data-nm": nm }), `${nm} nm`);
}

function paintSwatches() {
  for (const swatch of document.querySelectorAll(".swatch[data-nm]"))
    swatch.style.background = wavelengthColor(Number(swatch.dataset.nm));
}

// A row of buttons of which one is pressed. choices: [{value, label}].
// At most `most` of a list, evenly spread, first and last among them: nobody looks at ninety panels.
function spread(list, most) {
  if (list.length <= most) return list;
  return Array.from({ length: most }, (_, i) => list[Math.round(i * (list.length - 1) / (most - 1))]);
}

function chooser(title, choices, initial, onchange) {
  const buttons = choices.map((choice) => h("button", {
    type: "button", "aria-pressed": String(choice.value === initial),
    onclick: () => {
      for (const b of buttons) b.setAttribute("aria-pressed", String(b === buttons[choices.indexOf(choice)]));
      onchange(choice.value);
    },
  }, choice.label));
  return h("div", { class: "chooser", role: "group", "aria-label": title },
    h("span", { class: "chooser-title" }, title), h("span", { class: "buttons" }, buttons));
}

function section(id, title, lead, ...content) {
  return h("section", { id, class: "part", "data-short": SHORT_TITLES[title] || title }, h("h3", {}, title),
    lead ? h("p", { class: "lead" }, lead) : null, content);
}

// For the list of contents.
const SHORT_TITLES = {
  "BRDF in the plane of incidence": "BRDF in the plane", "Degree of linear polarisation": "DOLP",
    "Out of the plane of incidence": "Out of the plane",
  "What the data determine": "Identifiability", "Directional-hemispherical reflectance": "DHR",
};

function angle(deg) {
  return `${Number(deg.toFixed(2))}°`.replace("-", "−");
}

function stateLabel(state) {
  return `${state.polarizer} → ${state.analyzer}`;
}
