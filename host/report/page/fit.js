// What the fit found: K_N, parameters, directional-hemispherical reflectance, and what stays undetermined.

// Cells come as {text, mark}: mark names why the number must not be taken alone.
const MARKS = {
  fixed: ["fixed", "held at the user's value"],
  lower: ["<", "the optimum lies on the lower bound: upper end of the 95 % interval"],
  upper: [">", "the optimum lies on the upper bound: lower end of the 95 % interval"],
  weak: ["∗", "not determined by itself: see below"],
};

function estimateCell(cell) {
  if (!cell) return "–";
  const mark = cell.mark ? MARKS[cell.mark] : null;
  return h("span", { class: "estimate" + (cell.mark ? ` ${cell.mark}` : ""), title: cell.interval || null },
    cell.text, mark && (cell.mark === "fixed" || cell.mark === "weak")
      ? h("sup", { class: "mark", title: mark[1] }, mark[0]) : null);
}

function footnotes(rows) {
  const used = new Set(rows.flatMap((r) => r.cells).filter(Boolean).map((c) => c.mark).filter(Boolean));
  if (!used.size) return null;
  return h("p", { class: "note" }, [...used].map((m, i) => [i ? "; " : "", h("b", {}, MARKS[m][0]), ` ${MARKS[m][1]}`]),
    ".");
}

function estimateTable(fit, rows, caption, firstColumn) {
  const units = rows.some((row) => row.unit);
  const columns = [{ title: firstColumn, align: "left" }, ...fit.wavelengths_nm.map((nm) => ({ wavelength_nm: nm })),
    ...(units ? [{ title: "unit", align: "left" }] : [])];
  const body = rows.map((row) => {
    const role = row.role || row.meaning;
    return { row, name: h("span", { title: row.name }, symbol(row.name),
      role ? h("span", { class: "role" }, role) : null) };
  });
  const node = table(columns, body.map(({ name, row }) => [name,
    ...(row.shared ? [estimateCell(row.cells[0]), ...fit.wavelengths_nm.slice(1).map(() => "")]
      : row.cells.map(estimateCell)), ...(units ? [row.unit] : [])]), { caption });
  // One value for all wavelengths spans them.
  [...node.querySelectorAll("tbody tr")].forEach((tr, i) => {
    if (!rows[i].shared || fit.wavelengths_nm.length < 2) return;
    const cells = [...tr.children];
    for (const extra of cells.slice(2, 1 + fit.wavelengths_nm.length)) extra.remove();
    cells[1].setAttribute("colspan", String(fit.wavelengths_nm.length));
    cells[1].classList.add("shared");
  });
  return node;
}

function fitSection(sample, prefix) {
  const fit = sample.fit;
  const content = [];
  if (fit.k_n) content.push(estimateTable(fit, fit.k_n,
    [h("i", { class: "matrix" }, "K"), h("sub", {}, "N"), ": the weights of the four Li–Torrance components"],
    "component"), footnotes(fit.k_n));
  if (fit.parameters.length) content.push(estimateTable(fit, fit.parameters,
    fit.k_n ? "Other parameters" : `Parameters of ${fit.model}`, "parameter"), footnotes(fit.parameters));
  if (fit.derived.length) content.push(estimateTable(fit, fit.derived, "Derived", "quantity"), footnotes(fit.derived));
  const lead = `${fit.summary} Numbers are estimate ± half the width of the 95 % interval; the interval itself shows on hover.`;
  return section(`${prefix}-fit`, "Fit", lead, content);
}

function identifiabilitySection(sample, prefix) {
  const fit = sample.fit;
  const list = (sentences) => h("ul", { class: "sentences" }, sentences.map((s) => h("li", {}, s)));
  const content = [];
  content.push(fit.identifiability.length ? list(fit.identifiability)
    : h("p", {}, "Every free parameter is determined by the data on its own."));
  if (fit.notes.length) content.push(h("h4", {}, "Remarks of the fit"), list(fit.notes));
  if (fit.factors.length) {
    const largest = fit.factors.reduce((a, b) => (Math.abs(b.value) > Math.abs(a.value) ? b : a));
    content.push(h("details", { class: "provenance", open: fit.factors.length <= 8 },
      h("summary", {}, h("b", {}, "Calibration errors as the fit found them"),
        ` ${fit.factors.length} quantities; furthest from the calibration: ${largest.name}, ${largest.value.toFixed(1)} σ`.replace(" -", " −")),
      table([{ title: "calibration quantity", align: "left" }, { title: "shift found / σ" }],
        fit.factors.map((f) => [f.name, f.text]))));
  }
  if (fit.correlation) content.push(correlationFigure(fit).node);
  return section(`${prefix}-identifiability`, "What the data determine",
    "Parameters that can stand in for one another are known only in combination, however small the residuals.",
      content);
}

function correlationFigure(fit) {
  return figure("correlation", "Correlation of the fitted parameters", [], (width) => {
    const p = palette();
    const names = fit.correlation.names;
    const n = names.length;
    const longest = Math.max(...names.map((s) => s.length));
    const left = Math.min(width * 0.4, 16 + 6.6 * longest);
    const size = Math.min(width - left - 80, Math.max(220, n * 24));
    const z = names.map((_, i) => names.map((__, j) => (j > i ? null : fit.correlation.values[i * n + j])));
    const layout = {
      height: size + left + 24, margin: { l: left, r: Math.max(70, width - left - size), t: 12, b: left },
      xaxis: axis("", { showgrid: false, showline: false, ticks: "", tickangle: -90,
        tickfont: { size: 11, color: p.soft } }),
      yaxis: axis("", { showgrid: false, showline: false, ticks: "", autorange: "reversed",
        tickfont: { size: 11, color: p.soft } }), showlegend: false,
    };
    const data = [{ type: "heatmap", x: names, y: names, z, zmin: -1, zmax: 1,
      colorscale: isDark() ? DIVERGING_DARK : DIVERGING, xgap: 1, ygap: 1, hoverongaps: false,
      colorbar: { thickness: 10, len: Math.min(1, 200 / size), y: 1, yanchor: "top", outlinewidth: 0,
        tickvals: [-1, -0.5, 0, 0.5, 1], tickfont: { size: 11, color: p.soft } },
      hovertemplate: "%{y} with %{x}: %{z:.3f}<extra></extra>" }];
    return { data, layout,
      caption: "Linearised correlation of the free parameters at the optimum, calibration included. Strong colours off the diagonal are pairs that trade against each other." };
  });
}

function dhrSection(sample, prefix) {
  const dhr = sample.dhr;
  const columns = [{ title: "θi", align: "left" }, { title: "source", align: "left" },
    ...dhr.wavelengths_nm.map((nm) => ({ wavelength_nm: nm }))];
  const rows = dhr.rows.map((r) => [angle(r.theta_i_deg), r.source, ...r.cells.map((c) => c || "–")]);
  return section(`${prefix}-dhr`, "Directional-hemispherical reflectance", dhr.note, table(columns, rows));
}
