// The page from top to bottom.

// Key numbers: one column a wavelength, and beside them the figures of the fit as a whole.
function keyNumbers(sample) {
  const parts = [];
  if (sample.key.rows.length) parts.push(table(
    [{ title: "", align: "left" }, ...sample.wavelengths_nm.map((nm) => ({ wavelength_nm: nm }))],
    sample.key.rows.map((r) => [r.name, ...r.cells.map((c) => c || "–")]), { class: "key" }));
  parts.push(h("dl", { class: "facts" }, sample.key.facts.map((f) =>
    h("div", {}, h("dt", {}, f.name), h("dd", { class: f.tone || null }, f.value),
      f.note ? h("dd", { class: "fact-note" }, f.note) : null))));
  return h("div", { class: "key-numbers" }, parts.reverse());
}

function sampleArticle(sample) {
  const prefix = sample.id;
  const children = [
    h("header", { class: "sample-head" }, h("h2", {}, sample.name), h("p", { class: "meta" }, sample.meta.join(" · "))),
    sample.warnings.length ? h("ul", { class: "warnings" }, sample.warnings.map((w) => h("li", {}, w))) : null,
    sample.key.rows.length || sample.key.facts.length ? keyNumbers(sample) : null,
  ];
  if (sample.brdf) children.push(section(`${prefix}-brdf`, "BRDF in the plane of incidence", null,
    curveFigure(sample, "brdf").node));
  if (sample.dolp) children.push(section(`${prefix}-dolp`, "Degree of linear polarisation", null,
    curveFigure(sample, "dolp").node));
  if (sample.lobe) children.push(section(`${prefix}-lobe`, "Full BRDF", null, lobeFigure(sample).node));
  if (sample.prediction) {
    const set = sample.prediction;
    children.push(section(`${prefix}-prediction`, "Out of the plane of incidence", set.lead,
      predictionFigure(sample).node,
      table([{ title: "state", align: "left" }, { title: "λ", align: "left" }, { title: "in plane: n" },
        { title: "median" }, { title: "90 % below" },
        { title: "out of plane: n" }, { title: "median" }, { title: "90 % below" }, { title: "mean, signed" }],
      set.statistics.map((s) => [s.state, wavelengthLabel(s.wavelength_nm), s.in_plane.points, s.in_plane.median,
        s.in_plane.p90,
        s.out_of_plane.points, s.out_of_plane.median, s.out_of_plane.p90, s.out_of_plane.mean]),
          { caption: "Size of the relative error, |predicted/measured − 1|", class: "statistics" })));
  }
  if (sample.residuals) children.push(section(`${prefix}-residuals`, "Residuals", null, residualFigure(sample).node));
  if (sample.fit) {
    children.push(fitSection(sample, prefix));
    children.push(identifiabilitySection(sample, prefix));
  }
  if (sample.dhr) children.push(dhrSection(sample, prefix));
  if (sample.calibration) children.push(calibrationSection(sample.calibration, prefix));
  sample.scans.forEach((scan, i) => children.push(scanSection(scan, i, prefix,
    sample.scans.length > 1 ? `Raw scan: ${scan.name}` : "Raw scan")));
  if (sample.files.length) children.push(provenanceSection(sample, prefix));
  return h("article", { id: prefix, class: "sample" }, children);
}

function colophon() {
  document.getElementById("colophon").append(
    h("p", {}, "Every ± and every bar is a 95 % interval. θi, θr: angles of incidence and exit from the sample normal. In the plane of incidence θr is signed: positive on the mirror side, negative on the side of the source. "
      + "P: electric field in the plane of incidence; S: across it; U: no polariser, or no analyser. BRDF = dL/dE in sr⁻¹. DOLP = (PP − PS)/PU, first letter incident, second detected."),
    h("p", {}, `Written by ${DATA.program}. `, DATA.command ? ["Command: ", h("code", {}, DATA.command), ". "] : null,
      "Figures by plotly.js, © 2012–2021 Plotly, Inc., MIT licence (text in the source of this page). The page is complete in itself and asks nothing of the network."));
}

applyTheme();
masthead("Reflectance report");
document.getElementById("main").append(...DATA.samples.map(sampleArticle));
contents();
colophon();
paintSwatches();
watchSurroundings();
drawAllInTurn();
