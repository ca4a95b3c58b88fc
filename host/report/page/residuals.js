// Normalised residuals: what the model leaves, in units of what the measurement can tell apart.

function residualFigure(sample) {
  const set = sample.residuals;
  const choice = { theta: "all", state: "all" };
  const thetas = [{ value: "all", label: "all" }, ...spread(set.theta_i_deg, MOST_INCIDENCES).map((t) => ({ value: t, label: angle(t) }))];
  const states = [{ value: "all", label: "all" }, ...set.states.map((s) => ({ value: s.id, label: stateLabel(s) }))];
  const entry = figure("residuals", "Normalised residuals against exit angle", [
    thetas.length > 2 ? chooser("Incidence θi", thetas, "all", (v) => { choice.theta = v; entry.redraw(); }) : null,
    states.length > 2 ? chooser("Polariser → analyser", states, "all", (v) => { choice.state = v; entry.redraw(); })
      : null,
  ], (width) => buildResiduals(sample, choice, width));
  return entry;
}

function buildResiduals(sample, choice, width) {
  const set = sample.residuals;
  const p = palette();
  const groups = set.groups.filter((g) => (choice.theta === "all" || g.theta_i_deg === choice.theta) &&
    (choice.state === "all" || g.state === choice.state));
  const all = groups.flatMap((g) => g.z);
  const sorted = all.map(Math.abs).sort((a, b) => a - b);
  const limit = Math.max(4, 1.15 * (sorted[Math.floor(0.99 * (sorted.length - 1))] || 0));
  const beyond = all.filter((z) => Math.abs(z) > limit).length;
  const within = all.filter((z) => Math.abs(z) <= 1.96).length;
  const data = [];
  const wide = width > 620;
  const points = all.length;
  for (const nm of sample.wavelengths_nm) {
    const mine = groups.filter((g) => g.wavelength_nm === nm);
    const x = mine.flatMap((g) => g.x);
    const z = mine.flatMap((g) => g.z);
    if (!x.length) continue;
    const color = wavelengthColor(nm);
    const symbol = wavelengthSymbol(sample, nm);
    data.push(legendEntry(`${nm} nm`, { color, symbol }));
    data.push({
      type: points > 6000 && webglWorks() ? "scattergl" : "scatter", mode: "markers", x, name: `${nm} nm`,
        legendgroup: `${nm} nm`, showlegend: false,
      y: z.map((v) => Math.max(-limit, Math.min(limit, v))),
      customdata: z, text: mine.flatMap((g) => g.x.map(() => `θ<sub>i</sub> = ${angle(g.theta_i_deg)}, ${g.label}`)),
      marker: { color, size: points > 2000 ? 3 : 4.5, opacity: points > 2000 ? 0.5 : 0.75,
        symbol: z.map((v) => v > limit ? "triangle-up-open" : v < -limit ? "triangle-down-open" : symbol) },
      hovertemplate: `${nm} nm, %{text}<br>θ<sub>r</sub> = %{x:.2f}°<br>residual %{customdata:.2f} σ<extra></extra>`,
    });
  }
  const bins = 32, step = (2 * limit) / bins;
  const density = new Array(bins).fill(0);
  for (const z of all) if (Math.abs(z) < limit) density[Math.floor((z + limit) / step)] += 1 / (all.length * step);
  data.push({ type: "bar", orientation: "h", y: density.map((_, i) => -limit + (i + 0.5) * step), x: density,
    width: step, xaxis: "x2", yaxis: "y",
    marker: { color: withAlpha(p.mark, 0.45), line: { width: 0 } }, showlegend: false, hoverinfo: "skip" });
  const normal = Array.from({ length: 121 }, (_, i) => -limit + (2 * limit * i) / 120);
  data.push({ type: "scatter", mode: "lines", y: normal,
    x: normal.map((v) => Math.exp(-0.5 * v * v) / Math.sqrt(2 * Math.PI)),
    xaxis: "x2", yaxis: "y", line: { color: p.text, width: 1.4 }, name: "unit normal", hoverinfo: "skip" });
  const split = wide ? 0.84 : 0.78;
  const layout = {
    height: 330, barmode: "overlay", bargap: 0,
    xaxis: axis(ANGLE_AXIS, { domain: [0, split - 0.02], range: [-90, 90], dtick: 30 }),
    xaxis2: axis("", { domain: [split, 1], anchor: "y", range: [0, 1.15 * Math.max(...density, limit < 12 ? 0.4 : 0)],
      showticklabels: false, ticks: "", showgrid: false }),
    yaxis: axis("(measured − model) / σ", { range: [-limit * 1.06, limit * 1.06], zeroline: true }),
    shapes: [-1.96, 1.96].map((v) => ({ type: "line", x0: 0, x1: 1, xref: "paper", y0: v, y1: v, yref: "y",
      line: { color: p.mark, width: 1, dash: "dot" } })),
  };
  const share = points ? (100 * within / points).toFixed(1) : "–";
  return { data, layout,
    caption: `${share} % of ${points.toLocaleString("en")} residuals lie within ±1.96 σ (dotted; 95 % if model and noise are right). `
    + `${set.note} A run of one sign is a shape that the model does not have.`
    + (beyond ? ` ${beyond} beyond the axis: open triangles on its edge.` : "") };
}
