// Measured against predicted, in the plane of incidence and out of it.

function predictionFigure(sample) {
  const set = sample.prediction;
  const choice = { state: set.states[0].id, nm: set.wavelengths_nm[0],
    theta: set.theta_i_deg[Math.floor(set.theta_i_deg.length / 2)] };
  const pick = (key) => (v) => { choice[key] = v; entry.redraw(); };
  const entry = figure("prediction", "Measured against predicted BRDF", [
    set.states.length > 1 ? chooser("Polariser → analyser",
      set.states.map((s) => ({ value: s.id, label: stateLabel(s) })), choice.state, pick("state")) : null,
    set.wavelengths_nm.length > 1 ? chooser("Map: λ",
      set.wavelengths_nm.map((nm) => ({ value: nm, label: `${nm} nm` })), choice.nm, pick("nm")) : null,
    set.theta_i_deg.length > 1 ? chooser("Map: θi", spread(set.theta_i_deg, MOST_INCIDENCES).map((t) => ({ value: t, label: angle(t) })),
      choice.theta, pick("theta")) : null,
  ], (width) => buildPrediction(sample, choice, width));
  return entry;
}

function buildPrediction(sample, choice, width) {
  const set = sample.prediction;
  const p = palette();
  const groups = set.groups.filter((g) => g.state === choice.state);
  const positive = groups.flatMap((g) => [...g.measured, ...g.model]).filter((v) => v > 0);
  let [low, high] = extent(positive, () => true);
  if (!(low < high)) { low *= 0.9; high *= 1.1; }
  const log = high / low > 5;
  const pad = log ? (high / low) ** 0.04 : 1;
  const range = log ? [Math.log10(low / pad), Math.log10(high * pad)]
    : [low - 0.05 * (high - low), high + 0.05 * (high - low)];
  const ends = log ? range.map((v) => 10 ** v) : range;
  const data = [{ type: "scatter", mode: "lines", x: ends, y: ends, line: { color: p.mark, width: 1, dash: "dot" },
    showlegend: false, hoverinfo: "skip" }];
  let inside = 0, outside = 0;
  for (const inPlane of [false, true]) for (const nm of set.wavelengths_nm) {
    const mine = groups.filter((g) => g.wavelength_nm === nm && g.in_plane === inPlane);
    const x = mine.flatMap((g) => g.model);
    if (!x.length) continue;
    if (inPlane) inside += x.length; else outside += x.length;
    const color = wavelengthColor(nm);
    data.push({ type: x.length > 4000 && webglWorks() ? "scattergl" : "scatter", mode: "markers", x,
      y: mine.flatMap((g) => g.measured),
      name: `${nm} nm ${inPlane ? "in plane" : "out of plane"}`,
      text: mine.flatMap((g) => g.theta_r_deg.map((t,
        i) => `θ<sub>i</sub> ${angle(g.theta_i_deg)}, θ<sub>r</sub> ${t.toFixed(1)}°, φ ${g.phi_r_deg[i].toFixed(1)}°`)),
      marker: inPlane ? { color, size: 7, symbol: wavelengthSymbol(sample, nm), line: { width: 1, color: p.paper } }
        : { color: withAlpha(color, 0.5), size: 4, symbol: "circle" },
      hovertemplate: `${nm} nm, %{text}<br>measured %{y:.4g}, predicted %{x:.4g} sr<sup>−1</sup><extra></extra>` });
  }
  const here = groups.filter((g) => g.wavelength_nm === choice.nm && g.theta_i_deg === choice.theta);
  const u = [], v = [], error = [], text = [], symbols = [];
  for (const g of here) g.theta_r_deg.forEach((t, i) => {
    u.push(Math.sin(t * RAD) * Math.cos(g.phi_r_deg[i] * RAD));
    v.push(Math.sin(t * RAD) * Math.sin(g.phi_r_deg[i] * RAD));
    error.push(100 * (g.model[i] / g.measured[i] - 1));
    symbols.push(g.in_plane ? "square" : "circle");
    text.push(`θ<sub>r</sub> ${t.toFixed(1)}°, φ ${g.phi_r_deg[i].toFixed(1)}°<br>measured ${g.measured[i].toPrecision(4)}, predicted ${g.model[i].toPrecision(4)} sr<sup>−1</sup>`);
  });
  const sorted = error.map(Math.abs).filter(Number.isFinite).sort((a, b) => a - b);
  const limit = Math.max(1, sorted[Math.floor(0.95 * (sorted.length - 1))] || 1);
  const margin = width > 760 ? { l: 66, r: 92, t: 62, b: 52 } : { l: 58, r: 82, t: 78, b: 20 };
  const pair = pairOf(width, margin, 0.9 * (width - margin.l - margin.r));
  const { wide } = pair;
  data.push({ type: "scatter", mode: "markers", x: u, y: v, xaxis: "x2", yaxis: "y2", text, customdata: error,
    showlegend: false,
    marker: { size: wide ? 9 : 7, symbol: symbols, color: error, cmin: -limit, cmax: limit,
      colorscale: isDark() ? DIVERGING_DARK : DIVERGING, line: { width: 0.6, color: p.mark },
      colorbar: Object.assign({ thickness: 12, outlinewidth: 0, ticksuffix: " %",
        tickfont: { size: 11.5, color: p.soft },
        title: { text: "predicted/measured − 1", side: "right", font: { size: 12, color: p.soft } }, x: 1.0,
          xanchor: "left" }, pair.bar) },
    hovertemplate: "%{text}<br>error %{customdata:.2f} %<extra></extra>" });
  const axisOf = (title, extra) => log ? logAxis(title, 10 ** range[0], 10 ** range[1], extra)
    : axis(title, Object.assign({ range }, extra));
  const ring = (t) => ({ type: "circle", xref: "x2", yref: "y2", x0: -Math.sin(t * RAD), x1: Math.sin(t * RAD),
    y0: -Math.sin(t * RAD), y1: Math.sin(t * RAD),
    line: { color: p.zero, width: t === 90 ? 1.2 : 0.7, dash: t === 90 ? "solid" : "dot" } });
  const layout = {
    height: pair.height, margin,
    xaxis: axisOf("predicted BRDF / sr<sup>−1</sup>", { domain: pair.first.x, anchor: "y" }),
    yaxis: axisOf("measured BRDF / sr<sup>−1</sup>", { domain: pair.first.y, anchor: "x" }),
    xaxis2: { visible: false, domain: pair.second.x, range: [-1.12, 1.12], anchor: "y2" },
    yaxis2: { visible: false, domain: pair.second.y, range: [-1.12, 1.12], anchor: "x2" },
    shapes: [30, 60, 90].map(ring),
    annotations: [{ xref: "x2", yref: "y2", x: 0, y: -1.04,
      text: `${choice.nm} nm, θ<sub>i</sub> = ${angle(choice.theta)}`, showarrow: false,
      font: { size: 12.5, color: p.text }, yanchor: "top" },
      { xref: "x2", yref: "y2", x: Math.sin(choice.theta * RAD), y: 0, text: "×", showarrow: false,
        font: { size: 18, color: p.text } }],
  };
  return { data, layout,
    caption: `Large symbols: ${inside.toLocaleString("en")} points in the plane of incidence; small dots: ${outside.toLocaleString("en")} outside it. ${set.note} `
    + `On the dotted line prediction and measurement agree. ${wide ? "Right" : "Below"}: relative error by direction (direction cosines, forward to the right, mirror direction ×), for one wavelength and incidence.` };
}

const DIVERGING = [[0, "#2166ac"], [0.25, "#7fb6d9"], [0.5, "#f4f4f4"], [0.75, "#ee9a78"], [1, "#b2182b"]];
const DIVERGING_DARK = [[0, "#6db3f2"], [0.25, "#3a6d9e"], [0.5, "#2a2f37"], [0.75, "#a8573d"], [1, "#ff8a6b"]];
