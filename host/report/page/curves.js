// BRDF and DOLP in the plane of incidence: one panel an incidence angle (or a polarisation state),
// one colour and marker a wavelength, points with 95 % bars, the model as a line.

// Traces of one panel; `curves` are those that belong in it.
function panelTraces(sample, curves, i, seen, options) {
  const traces = [];
  for (const curve of curves) {
    const nm = curve.wavelength_nm;
    const color = wavelengthColor(nm);
    const name = `${nm} nm`;
    const common = { xaxis: axisName("x", i), yaxis: axisName("y", i), legendgroup: name };
    if (curve.x.length) {
      seen.add(nm);
      traces.push(Object.assign({
        type: "scatter", mode: "markers", x: curve.x, y: curve.y, name, showlegend: false,
        marker: { color, symbol: wavelengthSymbol(sample, nm), size: options.markerSize, opacity: 0.85,
          line: { width: 0 } },
        error_y: { type: "data", array: curve.u.map((u) => 1.96 * u), color: withAlpha(color, 0.55), thickness: 1,
          width: 0 },
        hovertemplate: `${name}<br>θ<sub>r</sub> = %{x:.2f}°<br>${options.quantity} = %{y:.4g} ± %{error_y.array:.2g} (95 %)<extra></extra>`,
      }, common));
    }
    if (curve.flagged && curve.flagged.x.length) traces.push(Object.assign({
      type: "scatter", mode: "markers", x: curve.flagged.x, y: curve.flagged.y, name: "flagged", showlegend: false,
      marker: { color: palette().mark, symbol: "x-thin-open", size: 6, line: { width: 1.2 } },
      hovertemplate: `${name}, flagged, not fitted<br>θ<sub>r</sub> = %{x:.2f}°<br>%{y:.4g}<extra></extra>`,
    }, common));
    if (curve.model) {
      seen.add(nm);
      traces.push(Object.assign({
        type: "scatter", mode: "lines", x: curve.model.x, y: curve.model.y, name, showlegend: false,
        line: { color, width: 1.8, dash: wavelengthDash(sample, nm) },
        hovertemplate: `${name} model<br>θ<sub>r</sub> = %{x:.2f}°<br>${options.quantity} = %{y:.4g}<extra></extra>`,
      }, common));
    }
  }
  return traces;
}

// kind: "brdf" or "dolp". Panels over θi, or over states at one θi.
function curveFigure(sample, kind) {
  const set = sample[kind];
  const isBrdf = kind === "brdf";
  const states = set.states || null;
  const choice = {
    across: set.theta_i_deg.length > 1 || !states || states.length < 2 ? "incidence" : "state",
    state: states ? states[0].id : null,
    theta: set.theta_i_deg[Math.min(set.theta_i_deg.length - 1, Math.floor(set.theta_i_deg.length / 2))],
    range: "all", scale: isBrdf && set.log ? "log" : "linear",
  };
  const stateChooser = states && states.length > 1 ? chooser("Polariser → analyser",
    states.map((s) => ({ value: s.id, label: stateLabel(s) })), choice.state,
      (v) => { choice.state = v; entry.redraw(); }) : null;
  const thetaChooser = set.theta_i_deg.length > 1 ? chooser("Incidence θi",
    spread(set.theta_i_deg, MOST_INCIDENCES).map((t) => ({ value: t, label: angle(t) })), choice.theta,
      (v) => { choice.theta = v; entry.redraw(); }) : null;
  const showChoosers = () => {
    if (stateChooser) stateChooser.hidden = choice.across !== "incidence";
    if (thetaChooser) thetaChooser.hidden = choice.across !== "state";
  };
  const acrossChooser = stateChooser && thetaChooser ? chooser("Panels",
    [{ value: "incidence", label: "incidence" }, { value: "state", label: "polarisation" }], choice.across,
    (v) => { choice.across = v; showChoosers(); entry.redraw(); }) : null;
  const rangeChooser = chooser("θr", [{ value: "all", label: "all" }, { value: "mirror", label: "mirror ± 12°" }],
    choice.range, (v) => { choice.range = v; entry.redraw(); });
  const scaleChooser = isBrdf ? chooser("Scale", [{ value: "log", label: "log" }, { value: "linear", label: "linear" }],
    choice.scale, (v) => { choice.scale = v; entry.redraw(); }) : null;
  showChoosers();
  const entry = figure(kind, isBrdf ? "BRDF against exit angle" : "Degree of linear polarisation against exit angle",
    [acrossChooser, stateChooser, thetaChooser, rangeChooser, scaleChooser],
      (width) => buildCurves(sample, kind, choice, width));
  return entry;
}

const MOST_INCIDENCES = 9;

function curvePanels(set, choice) {
  if (choice.across === "incidence") return spread(set.theta_i_deg, MOST_INCIDENCES).map((theta) => ({
    theta, title: `θ<sub>i</sub> = ${angle(theta)}`,
    curves: set.curves.filter((c) => c.theta_i_deg === theta && (choice.state === null || c.state === choice.state)),
  })).filter((p) => p.curves.length);
  return set.states.map((state) => ({
    theta: choice.theta, title: `${stateLabel(state)}`,
    curves: set.curves.filter((c) => c.theta_i_deg === choice.theta && c.state === state.id),
  })).filter((p) => p.curves.length);
}

function buildCurves(sample, kind, choice, width) {
  const set = sample[kind];
  const isBrdf = kind === "brdf";
  const panels = curvePanels(set, choice);
  const margins = { l: width < 560 ? 58 : 68, r: 14, t: 66, b: 52 };
  const grid = panelGrid(panels.length, width, panels.length > 6 ? 230 : isBrdf ? 300 : 250, margins);
  const layout = { margin: margins, height: grid.height, annotations: [], shapes: [] };
  const p = palette();
  const data = [];
  const seen = new Set();
  const log = isBrdf && choice.scale === "log";
  const inView = (panel, x) => choice.range === "all" || Math.abs(x - panel.theta) <= 12;
  let low = Infinity, high = -Infinity, hidden = 0, flagged = 0, shown = 0, hasModel = false;
  for (const panel of panels) for (const curve of panel.curves) {
    curve.x.forEach((x, n) => {
      if (!inView(panel, x)) return;
      shown += 1;
      if (log && curve.y[n] <= 0) { hidden += 1; return; }
      low = Math.min(low, curve.y[n]); high = Math.max(high, curve.y[n]);
    });
    flagged += curve.flagged ? curve.flagged.x.filter((x) => inView(panel, x)).length : 0;
    if (curve.model) {
      hasModel = true;
      // The model goes to grazing angles where nothing was measured: there it must not set the scale.
      const [from, to] = curve.x.length ? extent(curve.x, () => true) : [-90, 90];
      curve.model.x.forEach((x, n) => {
        if (!inView(panel, x) || x < from - 1 || x > to + 1 || (log && curve.model.y[n] <= 0)) return;
        high = Math.max(high, curve.model.y[n]);
        low = Math.min(low, curve.model.y[n]);
      });
    }
  }
  if (!(low < high)) { low = log ? 1e-3 : 0; high = 1; }
  const yTitle = isBrdf ? "BRDF / sr<sup>−1</sup>" : "DOLP";
  panels.forEach((panel, i) => {
    const cell = grid.cells[i];
    const xRange = choice.range === "all" ? [-90, 90] : [panel.theta - 12, panel.theta + 12];
    layout[axisKey("x", i)] = axis(cell.bottom ? ANGLE_AXIS : "", {
      domain: cell.x, anchor: axisName("y", i), range: xRange });
    if (choice.range === "all") Object.assign(layout[axisKey("x", i)], {
      tickvals: [-90, -60, -30, 0, 30, 60, 90], ticktext: [grid.columns > 1 ? "" : "−90", "−60", "−30", "0", "30", "60",
        grid.columns > 1 ? "" : "90"] });
    else layout[axisKey("x", i)].dtick = 4;
    const yExtra = { domain: cell.y, anchor: axisName("x", i), showticklabels: cell.column === 0 };
    if (i > 0) yExtra.matches = "y";
    layout[axisKey("y", i)] = log
      ? logAxis(cell.column === 0 ? yTitle : "", low / 1.6, high * 1.6, yExtra)
      : axis(cell.column === 0 ? yTitle : "", Object.assign({ zeroline: true, range: [
        Math.min(isBrdf ? 0 : -0.05, low - 0.06 * (high - low)),
          Math.max(high + 0.06 * (high - low), isBrdf ? 0 : 0.05)] }, yExtra));
    layout.annotations.push({ text: `<b>${panel.title}</b>`, x: cell.x[0], y: cell.y[1], xref: "paper", yref: "paper",
      xanchor: "left", yanchor: "bottom", yshift: 2, showarrow: false, font: { size: 13, color: p.text } });
    if (panel.theta < 89) layout.shapes.push({ type: "line", x0: panel.theta, x1: panel.theta, y0: cell.y[0],
      y1: cell.y[1],
      xref: axisName("x", i), yref: "paper", line: { color: p.mark, width: 1, dash: "dot" } });
    data.push(...panelTraces(sample, panel.curves, i, seen, { quantity: yTitle,
      markerSize: width < 560 ? 4 : 5 }));
  });
  for (const nm of [...seen].sort((a, b) => a - b)) {
    const color = wavelengthColor(nm);
    data.unshift(legendEntry(`${nm} nm`, { color, symbol: wavelengthSymbol(sample, nm) },
      hasModel ? { color, width: 1.8, dash: wavelengthDash(sample, nm) } : null));
  }
  layout.legend = Object.assign(baseLayout().legend,
    { y: 1 + 24 / (grid.height - margins.t - margins.b), traceorder: "reversed" });
  const where = choice.across === "incidence"
    ? (choice.state === null ? "" : ` for ${stateWords(set.states.find((s) => s.id === choice.state))}`)
    : ` at θi = ${angle(choice.theta)}`;
  const parts = [
    isBrdf ? `Measured BRDF${where}` : "Measured degree of linear polarisation, (PP − PS)/PU",
    shown ? ": dots, with 95 % bars that hold noise and calibration; " : ": nothing measured here; ",
    hasModel ? `lines, the fitted ${sample.fit.model} model; ` : "",
    "dotted, the mirror direction.",
    isBrdf ? "" : " Near 1 the light comes from the surface itself, near 0 it has been depolarised inside the material.",
    hidden ? ` ${hidden} point${hidden > 1 ? "s" : ""} at or below zero cannot be shown on the logarithmic scale.` : "",
    choice.across === "incidence" && set.theta_i_deg.length > MOST_INCIDENCES
      ? ` ${panels.length} of ${set.theta_i_deg.length} incidences are shown.` : "",
    flagged ? ` Grey crosses: ${flagged} flagged point${flagged > 1 ? "s" : ""}, not fitted.` : "",
  ];
  return { data, layout, caption: parts.join("") };
}

function stateWords(state) {
  if (!state) return "";
  const source = state.polarizer === "U" ? "unpolarised light" : `${state.polarizer}-polarised light`;
  const detector = state.analyzer === "U" ? "no analyser" : `analyser at ${state.analyzer}`;
  return `${source}, ${detector}`;
}
