// The raw scan in the order of time, and the calibration behind the reduction.

function scanSection(scan, index, prefix, title) {
  const facts = table([{ title: "amplifier range", align: "left" }, { title: "records" }, { title: "largest |X| / V" },
    { title: "saturated" }],
    scan.ranges.map((r) => [`× ${r.gain}`, r.records, r.largest, r.saturated]), { caption: "Amplifier ranges used" });
  return section(`${prefix}-scan${index ? index + 1 : ""}`, title, scan.summary,
    ...(scan.records ? [scanFigure(scan).node, facts] : []));
}

function scanFigure(scan) {
  return figure("scan", "Raw lock-in signal against time", [], (width) => {
    const p = palette();
    const data = [];
    const many = scan.records > 5000 && webglWorks();
    const type = many ? "scattergl" : "scatter";
    const owner = { wavelengths_nm: scan.series.map((s) => s.wavelength_nm) };
    for (const s of scan.series) {
      const color = wavelengthColor(s.wavelength_nm);
      const name = `${s.wavelength_nm} nm`;
      const hover = (quantity) => `${name}, record %{customdata}<br>%{x:.1f} s<br>${quantity}<extra></extra>`;
      data.push(legendEntry(name, { color, symbol: wavelengthSymbol(owner, s.wavelength_nm) }));
      data.push({ type, mode: "markers", x: s.time_s, y: s.signal_v, customdata: s.index, name, legendgroup: name,
        showlegend: false,
        marker: { color, size: scan.records > 2000 ? 2.5 : 4, opacity: 0.7,
          symbol: wavelengthSymbol(owner, s.wavelength_nm) }, hovertemplate: hover("|X| = %{y:.4g} V") });
      data.push({ type, mode: "markers", x: s.time_s, y: s.monitor, customdata: s.index, name, legendgroup: name,
        showlegend: false, yaxis: "y2",
        marker: { color, size: 2.5, opacity: 0.7 }, hovertemplate: hover("monitor / median = %{y:.5f}") });
      data.push({ type, mode: "markers", x: s.time_s, y: s.gain, customdata: s.index, name, legendgroup: name,
        showlegend: false, yaxis: "y3",
        marker: { color, size: 4, opacity: 0.6, symbol: "line-ns-open" }, hovertemplate: hover("range × %{y}") });
    }
    if (scan.saturated.time_s.length) data.push({ type, mode: "markers", x: scan.saturated.time_s,
      y: scan.saturated.signal_v, name: "saturated",
      marker: { color: p.text, size: 9, symbol: "x-thin-open", line: { width: 1.6 } },
        hovertemplate: "saturated, %{x:.1f} s<extra></extra>" });
    const signals = scan.series.flatMap((s) => s.signal_v).filter((v) => v > 0);
    const [low, high] = signals.length ? extent(signals, () => true) : [1e-6, 1];
    const times = scan.series.flatMap((s) => s.time_s);
    const [first, last] = times.length > 1 ? extent(times, () => true) : [0, 1];
    const gains = [...new Set(scan.series.flatMap((s) => s.gain))].sort((a, b) => a - b);
    const layout = {
      height: 470, margin: { l: width < 560 ? 58 : 72, r: 14, t: 36, b: 52 },
      xaxis: axis("time since the first record / s",
        { anchor: "y3", range: [first - 0.01 * (last - first), last + 0.01 * (last - first)] }),
      yaxis: logAxis("|X| / V at range 1", low / 1.5, high * 1.5, { domain: [0.45, 1] }),
      yaxis2: axis("monitor", { domain: [0.2, 0.39] }),
      yaxis3: axis("range", { domain: [0, 0.13], type: gains.length > 1 ? "log" : "linear", tickvals: gains,
        ticktext: gains.map((g) => `×${g}`),
        range: gains.length > 1 ? [Math.log10(gains[0]) - 0.4, Math.log10(gains[gains.length - 1]) + 0.4]
          : undefined }),
    };
    return { data, layout,
      caption: `Top: the in-phase lock-in output of every record${scan.thinned}, in volts referred to amplifier range 1, in the order in which it was taken. `
      + "Middle: source monitor relative to its median; slow drift here is divided out, steps are filters. Bottom: amplifier range chosen for the record." };
  });
}

function calibrationSection(calibration, prefix) {
  const content = [];
  const columns = [{ title: "", align: "left" }, ...calibration.wavelengths_nm.map((nm) => ({ wavelength_nm: nm }))];
  content.push(table(columns, calibration.rows.map((r) => [r.name, ...r.cells]), { caption: "Per wavelength" }));
  if (calibration.checks.length) content.push(table(
    [{ title: "standard", align: "left" }, { title: "λ" }, { title: "stated DHR" }, { title: "computed from its scan" },
      { title: "role", align: "left" }],
    calibration.checks.map((c) => [c.standard, `${c.wavelength_nm} nm`, c.stated, c.computed, c.role]),
      { caption: "Reference standards" }));
  if (calibration.curves.length) content.push(instrumentFigure(calibration).node);
  if (calibration.notes.length) content.push(h("ul", { class: "sentences" },
    calibration.notes.map((n) => h("li", {}, n))));
  return section(`${prefix}-calibration`, "Calibration", calibration.summary, content);
}

function instrumentFigure(calibration) {
  return figure("instrument", "Instrument function against exit angle", [], (width) => {
    const data = [];
    for (const curve of calibration.curves) {
      const color = wavelengthColor(curve.wavelength_nm);
      const name = `${curve.wavelength_nm} nm`;
      const band = curve.value.map((v, i) => v + 1.96 * curve.u[i]);
      const under = curve.value.map((v, i) => v - 1.96 * curve.u[i]);
      data.push({ type: "scatter", mode: "lines", x: [...curve.theta_r_deg, ...[...curve.theta_r_deg].reverse()],
        y: [...band, ...under.reverse()], fill: "toself",
        fillcolor: withAlpha(color, 0.14), line: { width: 0 }, legendgroup: name, showlegend: false,
          hoverinfo: "skip" });
      data.push({ type: "scatter", mode: "lines", x: curve.theta_r_deg, y: curve.value, name, legendgroup: name,
        line: { color, width: 1.8 },
        hovertemplate: `${name}<br>θ<sub>r</sub> = %{x:.1f}°<br>IF = %{y:.4f}<extra></extra>` });
    }
    const layout = { height: 280, margin: { l: width < 560 ? 58 : 68, r: 14, t: 34, b: 52 },
      xaxis: axis(ANGLE_AXIS, { range: [-90, 90], dtick: 30 }), yaxis: axis("instrument function", {}) };
    return { data, layout,
      caption: "A measured BRDF is multiplied by this function; 1 means an instrument that sees the same area at every angle. Bands: 95 %, from the noise of the standard's scan." };
  });
}

function provenanceSection(sample, prefix) {
  return section(`${prefix}-provenance`, "Provenance", "What each file says about its own making.",
    sample.files.map((file) => h("details", { class: "provenance", open: sample.files.length <= 1 },
      h("summary", {}, h("b", {}, file.name), ` ${file.kind}`),
      h("div", { class: "table-scroll wide" }, h("table", { class: "keys" }, h("tbody", {},
        file.rows.map(([key, value]) => h("tr", {}, h("th", { scope: "row", class: "left" }, key),
          h("td", { class: "left" }, value)))))))));
}
