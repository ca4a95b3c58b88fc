// Residuals of a diagnosis: maps over both angles, before and after, and the order of measurement.

// Below zero the measurement is darker than the simulation; the middle is the page's own ground.
function divergingScale() {
  return isDark()
    ? [[0, "#7cc0ff"], [0.25, "#2f6aa5"], [0.5, "#1b1f26"], [0.75, "#a8492c"], [1, "#ffa271"]]
    : [[0, "#1d5fa8"], [0.25, "#8fc0e2"], [0.5, "#f7f7f7"], [0.75, "#f2a482"], [1, "#ae1a2c"]];
}

const UNITS = [{ value: "sigma", label: "σ" }, { value: "percent", label: "% of signal" }];

function mapsFigure(set) {
  // Where single records show nothing but their noise, neighbours together do.
  const choice = { unit: "sigma", part: "x", cells: DATA.maps.clip_sigma > 4 ? "fine" : "coarse" };
  const entry = figure("maps", `Residuals ${set.title}`, [
    chooser("Residual in", UNITS, choice.unit, (v) => { choice.unit = v; entry.redraw(); }),
    chooser("Lock-in output", [{ value: "x", label: "in phase, X" }, { value: "y", label: "quadrature, Y" }], choice.part,
      (v) => { choice.part = v; entry.redraw(); }),
    chooser("Cells", [{ value: "fine", label: "single records" }, { value: "coarse", label: "neighbours joined" }],
      choice.cells, (v) => { choice.cells = v; entry.redraw(); }),
  ], (width) => buildMaps(set, choice, width));
  return entry;
}

function buildMaps(set, choice, width) {
  const p = palette();
  const maps = DATA.maps;
  const nms = maps.wavelengths_nm.filter((nm) => set.panels.some((q) => q.wavelength_nm === nm));
  const channels = maps.channels.filter((c) => set.panels.some((q) => q.channel === c));
  const times = DATA.explained ? ["before", "after"] : ["before"];
  const percent = choice.unit === "percent";
  const clip = percent ? maps.clip_percent : maps.clip_sigma;
  const unit = percent ? "%" : "σ";
  const theta = set.theta_r_deg[choice.cells];
  const step = theta.length > 1 ? theta[1] - theta[0] : 1;
  const longest = Math.max(...set.rows.map((r) => r.length));
  const margin = { l: Math.min(0.4 * width, 34 + 6.4 * longest), r: width < 560 ? 56 : 70, t: 50, b: 48 };
  const inner = width - margin.l - margin.r;
  const beside = times.length === 1 || inner / (2 * nms.length) >= 92;
  const columns = nms.length * (beside ? times.length : 1);
  const blocks = beside ? 1 : times.length;
  const gapX = 6, blockGapX = beside && times.length > 1 ? 22 : 0;
  const panelWidth = (inner - blockGapX - gapX * (columns - 1)) / columns;
  // High enough for the channel's name, which stands upright beside it.
  const panelHeight = Math.max(58, 7.4 * Math.max(...channels.map((c) => c.length)), Math.min(170, 15 * set.rows.length));
  const gapY = 10, blockGapY = 62;
  const plotHeight = blocks * (channels.length * panelHeight + (channels.length - 1) * gapY) + (blocks - 1) * blockGapY;
  const layout = { margin, height: plotHeight + margin.t + margin.b, annotations: [], showlegend: false,
    coloraxis: { colorscale: divergingScale(), cmin: -clip, cmax: clip, colorbar: {
      thickness: 12, len: Math.min(1, 260 / plotHeight), y: 1, yanchor: "top", outlinewidth: 0, x: 1.005, xpad: 6,
      tickfont: { size: 11, color: p.soft }, ticksuffix: percent ? "" : "",
      title: { text: unit, side: "top", font: { size: 12, color: p.soft } } } } };
  const data = [];
  let n = 0, shown = 0, unshown = 0;
  const note = (text, x, y, extra) => layout.annotations.push(Object.assign({ text, x, y, xref: "paper", yref: "paper",
    showarrow: false, font: { size: 12.5, color: p.text } }, extra));
  const titles = { before: DATA.explained ? "<b>Before</b>: the base model" : "<b>The base model</b>",
    after: DATA.verdict === "unexplained" ? "<b>After</b>: with what fits best" : "<b>After</b>: with the causes" };
  times.forEach((time, t) => {
    const block = beside ? 0 : t;
    const top = block * (channels.length * panelHeight + (channels.length - 1) * gapY + blockGapY);
    const left = beside && t === 1 ? nms.length * (panelWidth + gapX) - gapX + blockGapX : 0;
    note(titles[time], left / inner, 1 - top / plotHeight, { xanchor: "left", yanchor: "bottom", yshift: 20,
      font: { size: 13.5, color: p.text } });
    channels.forEach((channel, row) => nms.forEach((nm, column) => {
      const panel = set.panels.find((q) => q.channel === channel && q.wavelength_nm === nm);
      const x0 = left + column * (panelWidth + gapX);
      const y0 = top + row * (panelHeight + gapY);
      if (row === 0) note(`${nm} nm`, (x0 + panelWidth / 2) / inner, 1 - top / plotHeight, { xanchor: "center",
        yanchor: "bottom", yshift: 2, font: { size: 12, color: wavelengthColor(nm) } });
      if (!panel) return;
      const cells = panel[choice.part][choice.cells];
      const z = cells[time].map((line, r) => line.map((v, c) => {
        if (v === null || !percent) return v;
        const scale = cells.scale[r][c];
        return scale === null ? null : v * scale;
      }));
      for (const line of z) for (const v of line) if (v !== null) { shown += 1; if (Math.abs(v) > clip) unshown += 1; }
      const first = column === 0 && left === 0;
      const bottom = row === channels.length - 1;
      layout[axisKey("x", n)] = axis("", { domain: [x0 / inner, (x0 + panelWidth) / inner], anchor: axisName("y", n),
        dtick: panelWidth < 150 ? 60 : 30, tick0: 0, showticklabels: bottom, showgrid: false, ticks: bottom ? "outside" : "",
        range: [theta[0] - step / 2, theta[theta.length - 1] + step / 2] });
      layout[axisKey("y", n)] = axis(first ? channel : "", { domain: [1 - (y0 + panelHeight) / plotHeight, 1 - y0 / plotHeight],
        anchor: axisName("x", n), tickvals: set.rows.map((_, i) => i), ticktext: set.rows, showticklabels: first,
        showgrid: false, ticks: "", range: [-0.5, set.rows.length - 0.5],
        tickfont: { size: Math.max(7, Math.min(11, panelHeight / set.rows.length - 2)), color: p.soft } });
      if (first) layout[axisKey("y", n)].title.standoff = 6;
      data.push({ type: "heatmap", x: theta, y: set.rows.map((_, i) => i), z, coloraxis: "coloraxis", ygap: 1,
        hoverongaps: false, xaxis: axisName("x", n), yaxis: axisName("y", n), customdata: set.rows.map((r) => theta.map(() => r)),
        hovertemplate: `${nm} nm, ${channel}<br>θ<sub>i</sub> = %{customdata}, θ<sub>r</sub> = %{x:.1f}°<br>${time}: %{z:.3g} ${unit}<extra></extra>` });
      if (panel.saturated) data.push({ type: "scatter", mode: "markers", x: panel.saturated.map((s) => s[0]),
        y: panel.saturated.map((s) => s[1]), xaxis: axisName("x", n), yaxis: axisName("y", n), name: "saturated",
        marker: { symbol: "x-thin-open", size: 6, color: p.text, line: { width: 1 } },
        hovertemplate: "saturated, not used<extra></extra>" });
      n += 1;
    }));
  });
  note(ANGLE_AXIS, 0.5, 0, { xanchor: "center", yanchor: "top", yshift: -22, font: { size: 12.5, color: p.soft } });
  const saturated = set.panels.reduce((sum, q) => sum + (q.saturated ? q.saturated.length : 0), 0);
  return { data, layout, caption: `Measured less simulated, ${percent ? "in per cent of the signal" : choice.cells === "fine" ? "in standard deviations of a single record" : "neighbours together, in standard deviations of their mean"}: `
    + "red where the measurement is brighter, blue where it is darker. Rows of a panel are angles of incidence θi; letters are polariser → analyser. "
    + `One scale for all panels; ${unshown ? `${(100 * unshown / shown).toFixed(1)} % of the cells lie beyond ±${clip} ${unit}, hover for their values` : `nothing lies beyond ±${clip} ${unit}`}.`
    + (percent ? " Where there is next to no signal no per cent can be given." : "")
    + (saturated ? ` Crosses: ${saturated} saturated records, not used.` : "") };
}

function traceFigure() {
  return figure("trace", "Residual in the order of measurement", [], (width) => {
    const p = palette();
    const trace = DATA.trace;
    const data = [];
    const color = { before: isDark() ? "#f5a94d" : "#c86a06", after: p.accent };
    for (const time of DATA.explained ? ["before", "after"] : ["before"]) data.push({
      type: "scatter", mode: "markers", x: trace.record, y: trace[time], name: time,
      marker: { color: color[time], size: 4.5, symbol: time === "before" ? "circle-open" : "circle" },
      error_y: { type: "data", array: trace.u.map((u) => 1.96 * u), color: withAlpha(color[time], 0.4), thickness: 1, width: 0 },
      hovertemplate: `record %{x}<br>${time}: %{y:.3g} %<extra></extra>` });
    const sizes = trace.before.concat(trace.after).map(Math.abs).sort((a, b) => a - b);
    const limit = 1.3 * (sizes[Math.floor(0.98 * (sizes.length - 1))] || 1);
    return { data, layout: { height: 280, margin: { l: width < 560 ? 58 : 68, r: 14, t: 34, b: 52 },
      xaxis: axis("record, in the order of measurement"),
      yaxis: axis("measured over simulated − 1 / %", { range: [-limit, limit], zeroline: true }) },
      caption: `Each point is the relative deviation that ${trace.block} successive records share (weighted by their noise), with its 95 % bar. `
      + "A slope or a bend is drift of the source; steps are amplifier ranges, wavelengths or polarisers." };
  });
}
