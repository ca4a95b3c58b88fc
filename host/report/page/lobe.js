// The full BRDF: a three-dimensional lobe and, beside it, the same hemisphere seen from above.

function lobeFigure(sample) {
  const lobe = sample.lobe;
  const middle = lobe.grids[Math.min(lobe.grids.length - 1, Math.floor(lobe.grids.length / 2))];
  const choice = { theta: middle.theta_i_deg, nm: lobe.wavelengths_nm[0], radius: lobe.log ? "log" : "linear",
    color: "brdf" };
  const set = (key) => (v) => { choice[key] = v; entry.redraw(); };
  const entry = figure("lobe", "Full BRDF over the hemisphere", [
    lobe.grids.length > 1 ? chooser("Incidence θi",
      lobe.grids.map((g) => ({ value: g.theta_i_deg, label: angle(g.theta_i_deg) })), choice.theta, set("theta"))
      : null,
    lobe.wavelengths_nm.length > 1 ? chooser("λ", lobe.wavelengths_nm.map((nm) => ({ value: nm, label: `${nm} nm` })),
      choice.nm, set("nm")) : null,
    chooser("Radius", [{ value: "log", label: "log" }, { value: "linear", label: "linear" }], choice.radius,
      set("radius")),
    chooser("Colour", [{ value: "brdf", label: "BRDF" }, { value: "dolp", label: "DOLP" }], "brdf", set("color")),
  ], (width) => buildLobe(sample, choice, width), { webgl: true });
  return entry;
}

const RAD = Math.PI / 180;
const SUPERSCRIPT = (n) => `10<sup>${String(n).replace("-", "−")}</sup>`;

// Tick text for a colour bar whose value is log10 of the quantity.
function decadeTicks(low, high) {
  const values = [], text = [];
  const span = high - low;
  const fine = span < 1.2 ? [1, 1.5, 2, 3, 4, 5, 6, 8] : span < 2.2 ? [1, 2, 5] : [1];
  for (let d = Math.floor(low); d <= Math.ceil(high); d++) for (const f of fine) {
    const v = d + Math.log10(f);
    if (v < low - 1e-9 || v > high + 1e-9) continue;
    values.push(v);
    text.push(span < 2.2 ? String(Number((f * 10 ** d).toPrecision(2))) : SUPERSCRIPT(d));
  }
  if (values.length < 2) return { tickvals: [low, high], ticktext: [low, high].map((v) => (10 ** v).toPrecision(3)) };
  return { tickvals: values, ticktext: text };
}

function buildLobe(sample, choice, width) {
  const p = palette();
  const grid = sample.lobe.grids.find((g) => g.theta_i_deg === choice.theta);
  const brdf = grid.brdf[String(choice.nm)];
  const dolp = grid.dolp[String(choice.nm)];
  const nTheta = grid.theta_deg.length, nPhi = grid.phi_deg.length;
  const [lowest, highest] = extent(brdf, (v) => v > 0);
  // At most five decades: below that a logarithmic lobe shows only its own floor.
  const floor = Math.max(lowest, highest * 1e-5);
  const low = Math.log10(floor), high = Math.max(Math.log10(highest), low + 1e-6);
  const span = high - low;
  const base = Math.max(0.35, 0.3 * span);  // so that a nearly constant BRDF is a dome, not a point
  const radius = (f) => choice.radius === "linear" ? f / highest
    : (Math.max(0, Math.log10(Math.max(f, floor)) - low) + base) / (span + base);
  const shade = (k) => choice.color === "dolp" ? dolp[k] : Math.log10(Math.max(brdf[k], floor));
  const dolpRange = extent(dolp, Number.isFinite);
  const colors = choice.color === "dolp"
    ? { cmin: Math.min(0, dolpRange[0]), cmax: Math.max(1e-3, dolpRange[1] > 0.5 ? 1 : dolpRange[1]),
      colorscale: "Cividis", bar: { title: "DOLP" } }
    : { cmin: low, cmax: Math.max(high, low + 0.02), colorscale: "Viridis",
      bar: Object.assign({ title: "BRDF / sr<sup>−1</sup>" }, decadeTicks(low, high)) };
  const solid = webglWorks();
  const margin = { l: 10, r: width > 760 ? 92 : 76, t: 26, b: 30 };
  const pair = pairOf(width, margin, solid ? 0.8 * (width - margin.l - margin.r) : 0);
  const { wide } = pair;
  const bar = Object.assign({ thickness: 12, outlinewidth: 0, tickfont: { size: 11.5, color: p.soft } }, colors.bar,
    { title: { text: colors.bar.title, font: { size: 12.5, color: p.soft }, side: "right" }, x: 1.0, xanchor: "left" },
      pair.bar);
  const data = [];
  const mirrorPhi = (j) => (j < nPhi - 1 ? -grid.phi_deg[nPhi - 1 - j] : grid.phi_deg[j - nPhi + 1]);
  const index = (i, j) => i * nPhi + (j < nPhi - 1 ? nPhi - 1 - j : j - nPhi + 1);
  if (solid) {
    const x = [], y = [], z = [], c = [], hover = [];
    for (let i = 0; i < nTheta; i++) {
      const row = [[], [], [], [], []];
      const st = Math.sin(grid.theta_deg[i] * RAD), ct = Math.cos(grid.theta_deg[i] * RAD);
      for (let j = 0; j < 2 * nPhi - 1; j++) {
        const k = index(i, j);
        const phi = mirrorPhi(j);
        const r = radius(brdf[k]);
        row[0].push(r * st * Math.cos(phi * RAD)); row[1].push(r * st * Math.sin(phi * RAD)); row[2].push(r * ct);
        row[3].push(shade(k));
        row[4].push(`θ<sub>r</sub> ${grid.theta_deg[i].toFixed(1)}°, φ ${phi.toFixed(1)}°<br>BRDF ${brdf[k].toPrecision(4)} sr<sup>−1</sup><br>DOLP ${dolp[k] === null ? "–" : dolp[k].toFixed(3)}`);
      }
      x.push(row[0]); y.push(row[1]); z.push(row[2]); c.push(row[3]); hover.push(row[4]);
    }
    data.push({ type: "surface", x, y, z, surfacecolor: c, cmin: colors.cmin, cmax: colors.cmax,
      colorscale: colors.colorscale,
      showscale: false, text: hover, hovertemplate: "%{text}<extra></extra>",
        contours: { x: { highlight: false }, y: { highlight: false }, z: { highlight: false } },
      lighting: { ambient: 0.75, diffuse: 0.5, specular: 0.08, roughness: 0.9, fresnel: 0.05 } });
    data.push(...lobeScaffold(choice.theta, p));
  }
  data.push(hemisphereMap(grid, shade, nPhi, colors, bar));
  data.push(...mapOverlay(sample, choice, p));
  // The field of view is fixed by the height: a narrow picture needs a step back.
  const away = Math.max(1, 1.3 / pair.aspect);
  const none = { visible: false, fixedrange: true };
  const layout = {
    height: pair.height, margin, showlegend: false, uirevision: "lobe",
    xaxis: Object.assign({}, none, { domain: pair.second.x, range: [-1.12, 1.12] }),
    yaxis: Object.assign({}, none, { domain: pair.second.y, range: [-1.12, 1.12] }),
    shapes: mapRings(p), annotations: mapLabels(p, choice.theta),
  };
  if (solid) layout.scene = {
    domain: pair.first,
    aspectmode: "manual", aspectratio: { x: 1.5, y: 1.5, z: 0.83 }, uirevision: "lobe", dragmode: "turntable",
    camera: { eye: { x: 0.36 * away, y: -1.4 * away, z: 0.45 * away }, center: { x: 0, y: 0, z: -0.34 } },
    xaxis: { visible: false, range: [-1.1, 1.1], showspikes: false },
      yaxis: { visible: false, range: [-1.1, 1.1], showspikes: false },
    zaxis: { visible: false, range: [-0.02, 1.2], showspikes: false },
  };
  const dolpNote = choice.color === "dolp"
    ? " DOLP: the linearly polarised share √(Q² + U²)/I of the light that leaves where P-polarised light comes in; in the plane of incidence it is |PP − PS|/PU." : "";
  const scale = choice.radius === "log"
    ? `distance from the origin grows with log BRDF, from ${floor.toPrecision(2)} to ${highest.toPrecision(3)} sr⁻¹`
    : `distance from the origin is proportional to the BRDF, ${highest.toPrecision(3)} sr⁻¹ at its largest`;
  return { data, layout,
    caption: `${solid ? (wide ? "Left" : "Top") : "No WebGL in this browser, so no lobe"}: the fitted ${sample.fit.model} model for unpolarised light at ${choice.nm} nm, θi = ${angle(choice.theta)}; ${scale}. `
    + `Drag to turn it. ${wide ? "Right" : "Below"}: the same values in direction cosines, the mirror direction at the cross; dots mark measured directions, all else is prediction.${dolpNote} ${sample.lobe.note}` };
}

// The sample plane with rings every 30°, the beam that comes in, the mirror direction.
function lobeScaffold(theta, p) {
  const traces = [];
  const line = (x, y, z, extra) => Object.assign({ type: "scatter3d", mode: "lines", x, y, z, hoverinfo: "skip" },
    extra);
  const turn = Array.from({ length: 73 }, (_, i) => i * 5 * RAD);
  for (const r of [0.5, 1]) traces.push(line(turn.map((t) => r * Math.cos(t)), turn.map((t) => r * Math.sin(t)),
    turn.map(() => 0),
    { line: { color: p.zero, width: r === 1 ? 2 : 1 } }));
  traces.push(line([-1, 1], [0, 0], [0, 0], { line: { color: p.zero, width: 1 } }));
  const s = Math.sin(theta * RAD), c = Math.cos(theta * RAD);
  traces.push(line([-1.08 * s, 0], [0, 0], [1.08 * c, 0], { line: { color: p.text, width: 4 } }));
  traces.push(line([0, 1.08 * s], [0, 0], [0, 1.08 * c], { line: { color: p.text, width: 3, dash: "dot" } }));
  traces.push({ type: "scatter3d", mode: "text", x: [-1.1 * s - (s < 0.1 ? 0.08 : 0), 1.1 * s + (s < 0.1 ? 0.12 : 0)],
    y: [0, 0], z: [1.14 * c, 1.14 * c], text: ["light in", "mirror"],
    textfont: { size: 12, color: p.text }, hoverinfo: "skip" });
  return traces;
}

// Bilinear in θ and φ onto a square of direction cosines.
function hemisphereMap(grid, shade, nPhi, colors, bar) {
  const n = 201;
  const axisValues = Array.from({ length: n }, (_, i) => -1 + (2 * i) / (n - 1));
  const locate = (list, v) => {
    let a = 0, b = list.length - 1;
    if (v <= list[0]) return [0, 0];
    if (v >= list[b]) return [b - 1, 1];
    while (b - a > 1) { const m = (a + b) >> 1; if (list[m] <= v) a = m; else b = m; }
    return [a, (v - list[a]) / (list[a + 1] - list[a])];
  };
  const z = axisValues.map((v) => axisValues.map((u) => {
    const rho = Math.hypot(u, v);
    if (rho > 1) return null;
    const theta = Math.asin(rho) / RAD;
    if (theta > grid.theta_deg[grid.theta_deg.length - 1] + 1.5) return null;
    const [i, a] = locate(grid.theta_deg, theta);
    const [j, b] = locate(grid.phi_deg, Math.abs(Math.atan2(v, u)) / RAD);
    const k = i * nPhi + j;
    return (1 - a) * ((1 - b) * shade(k) + b * shade(k + 1))
      + a * ((1 - b) * shade(k + nPhi) + b * shade(k + nPhi + 1));
  }));
  return { type: "heatmap", x: axisValues, y: axisValues, z, zmin: colors.cmin, zmax: colors.cmax,
    colorscale: colors.colorscale,
    colorbar: bar, hoverinfo: "skip", zsmooth: "fast" };
}

function mapOverlay(sample, choice, p) {
  const mirror = Math.sin(choice.theta * RAD);
  const cross = (color, width) => ({ type: "scatter", mode: "markers", x: [mirror], y: [0],
    hovertemplate: "mirror direction<extra></extra>",
    marker: { symbol: "x-thin", size: 10, line: { width, color } } });
  const traces = [cross("#000000", 4), cross("#ffffff", 1.8)];
  const at = (sample.directions || []).find((d) => d.theta_i_deg === choice.theta && d.wavelength_nm === choice.nm);
  if (at) traces.unshift({ type: "scatter", mode: "markers", x: at.u, y: at.v, hoverinfo: "skip",
    marker: { size: 3, color: "rgba(255,255,255,0.75)", line: { width: 0.6, color: "rgba(0,0,0,0.55)" } } });
  return traces;
}

function mapRings(p) {
  return [30, 60, 90].map((t) => {
    const r = Math.sin(t * RAD);
    return { type: "circle", xref: "x", yref: "y", x0: -r, x1: r, y0: -r, y1: r,
      line: { color: t === 90 ? p.zero : "rgba(255,255,255,0.45)", width: t === 90 ? 1.2 : 0.8,
      dash: t === 90 ? "solid" : "dot" } };
  });
}

function mapLabels(p) {
  const text = (x, y, t, extra) => Object.assign({ x, y, xref: "x", yref: "y", text: t, showarrow: false,
    font: { size: 11.5, color: p.soft } }, extra);
  const ring = (t) => text(Math.sin(t * RAD) * Math.cos(Math.PI / 4), Math.sin(t * RAD) * Math.sin(Math.PI / 4),
    `${t}°`, { font: { size: 10.5, color: "rgba(255,255,255,0.9)" } });
  return [ring(30), ring(60), text(1.02, 0, "forward", { xanchor: "left", textangle: 90, xshift: -2 }),
    text(-1.02, 0, "retro", { xanchor: "right", textangle: -90, xshift: 2 }),
    text(0, 1.06, "φ = 90°"), text(0, -1.06, "φ = −90°")];
}
