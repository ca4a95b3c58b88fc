// The page of a luminance map's diagnosis from top to bottom.

const MM = { x: "x / mm", y: "y / mm" };

function luminanceScale() {
  return [[0, "#0d0887"], [0.25, "#7e03a8"], [0.5, "#cc4778"], [0.75, "#f89540"], [1, "#f0f921"]];
}

// Maps side by side under one scale of colours. panels: [{title, z, hover}].
function mapPanels(panels, width, scale) {
  const p = palette();
  const x = DATA.map.x_mm, y = DATA.map.y_mm;
  const margins = { l: 50, r: 84, t: 30, b: 48 };
  const inner = width - margins.l - margins.r;
  const columns = width > 560 ? panels.length : 1;
  const gap = 40;
  const panelWidth = (inner - gap * (columns - 1)) / columns;
  const panelHeight = panelWidth * y.length / x.length;
  const rows = Math.ceil(panels.length / columns);
  const gapY = 66;
  const plotHeight = rows * panelHeight + (rows - 1) * gapY;
  const layout = { margin: margins, height: plotHeight + margins.t + margins.b, showlegend: false, annotations: [],
    coloraxis: { colorscale: scale.colors, cmin: scale.from, cmax: scale.to, colorbar: { thickness: 12, len: Math.min(1, 300 / plotHeight),
      y: 1, yanchor: "top", outlinewidth: 0, x: 1.005, xpad: 6, tickfont: { size: 11, color: p.soft },
      title: { text: scale.unit, side: "top", font: { size: 12, color: p.soft } } } } };
  const data = panels.map((panel, i) => {
    const left = (i % columns) * (panelWidth + gap);
    const top = Math.floor(i / columns) * (panelHeight + gapY);
    layout[axisKey("x", i)] = axis(MM.x, { domain: [left / inner, (left + panelWidth) / inner], anchor: axisName("y", i), showgrid: false });
    layout[axisKey("y", i)] = axis(i % columns === 0 ? MM.y : "", { domain: [1 - (top + panelHeight) / plotHeight, 1 - top / plotHeight],
      anchor: axisName("x", i), showgrid: false });
    layout.annotations.push({ text: panel.title, x: left / inner, y: 1 - top / plotHeight, xref: "paper", yref: "paper", xanchor: "left",
      yanchor: "bottom", yshift: 4, showarrow: false, font: { size: 13, color: p.text } });
    return { type: "heatmap", x, y, z: panel.z, coloraxis: "coloraxis", hoverongaps: false, xaxis: axisName("x", i), yaxis: axisName("y", i),
      hovertemplate: `(%{x:.4g}, %{y:.4g}) mm<br>%{z:.4g} ${scale.unit}<extra></extra>` };
  });
  return { data, layout };
}

const AFTER = () => (DATA.verdict === "unexplained" ? "<b>After</b>: with what fits best" : "<b>After</b>: with the causes");

function luminanceFigure() {
  return figure("luminance", "Measured and simulated luminance", [], (width) => {
    const panels = [{ title: "<b>Measured</b>", z: DATA.map.measured }, { title: "<b>Before</b>: simulated", z: DATA.map.before }];
    if (DATA.explained) panels.push({ title: AFTER(), z: DATA.map.after });
    return Object.assign(mapPanels(panels, width, { colors: luminanceScale(), from: 0, to: DATA.map.largest, unit: "cd/m²" }), {
      caption: "Pixels that see the luminaire away from its outlines; seen by the camera, x to the right and y up from the lower left of its window." });
  });
}

function residualFigure() {
  const choice = { unit: "sigma" };
  const entry = figure("maps", "Residuals", [chooser("Residual in", UNITS, choice.unit, (v) => { choice.unit = v; entry.redraw(); })], (width) => {
    const maps = DATA.map.residual[choice.unit];
    const panels = [{ title: "<b>Before</b>", z: maps.before }];
    if (DATA.explained) panels.push({ title: AFTER(), z: maps.after });
    const unit = choice.unit === "sigma" ? "σ" : "%";
    return Object.assign(mapPanels(panels, width, { colors: divergingScale(), from: -maps.clip, to: maps.clip, unit }), {
      caption: "Measured less simulated: red where the measurement is brighter, blue where it is darker. One scale for both; "
        + `2 % of the pixels before may lie beyond ±${maps.clip} ${unit}.` });
  });
  return entry;
}

function mapSignatureFigure(signature) {
  const choice = { rest: "refitted" };
  const entry = figure("signature", `Signature of ${signature.plain}`, [
    chooser("The rest of the model", [{ value: "refitted", label: "fitted anew" }, { value: "held", label: "held" }], choice.rest,
      (v) => { choice.rest = v; entry.redraw(); })], (width) => {
    const view = signature[choice.rest];
    return Object.assign(mapPanels([{ title: "<b>Measured</b> less all else", z: view.left }, { title: `What <b>${signature.plain}</b> does`, z: view.does }],
      width, { colors: divergingScale(), from: -view.clip, to: view.clip, unit: "cd/m²" }), {
      caption: (choice.rest === "refitted" ? "All else fitted anew without it: what nothing but this explains. " : "Nothing else changed: all that it does. ")
        + `Without it χ² is larger by ${signature.delta_chi2}.` });
  });
  return entry;
}

function mapSignatures() {
  if (!DATA.signatures.length) return null;
  return section("signatures", "Signatures", "What each cause does to the map, beside what the simulation without it leaves.",
    DATA.signatures.map((s) => h("div", { class: "signature" },
      h("h4", {}, s.plain, s.family ? ` (${s.family})` : "", s.named ? null : h("span", { class: "role" }, "fits, but is not sure enough to be named")),
      mapSignatureFigure(s).node)));
}

function mapArticle() {
  return h("article", { id: "diagnosis", class: "sample" },
    verdictHead(),
    DATA.notes.length ? h("ul", { class: "warnings" }, DATA.notes.map((n) => h("li", {}, n))) : null,
    DATA.causes.bars.length ? causesSection() : null,
    section("gap", "Size of the gap", null, gapFigure().node),
    section("luminance", "Luminance", null, luminanceFigure().node),
    section("maps", "Residuals", null, residualFigure().node),
    mapSignatures(), whereSection(), baseSection(), provenanceSection());
}

showPage("Diagnosis of a luminance map", mapArticle,
  "x, y: in the camera's window. highlight: share of the strongest near-specular signature, 1 in the middle of a highlight. "
  + "σ: standard deviation of one pixel, of the measurement and the simulation together. ");
