// Causes of a gap: bars, signatures laid over the residual, the size of the gap, the scan to take next.

function barRow(bar) {
  const track = (share, text, kind) => h("div", { class: `bar ${kind}` },
    h("span", { class: "bar-fill", style: `width:${(100 * Math.max(0, Math.min(1, share))).toFixed(1)}%` }),
    h("span", { class: "bar-text" }, text));
  return h("div", { class: "bar-row" + (bar.named ? "" : " faint") },
    h("div", { class: "bar-label" }, bar.label, bar.named ? null : h("span", { class: "role" },
      bar.probability < 0.5 ? "not named" : "not named: rows held back do not confirm it")),
    track(bar.probability, bar.probability > 0.995 ? "> 0.99" : bar.probability.toFixed(2), "probability"),
    bar.share === undefined ? h("div", { class: "bar none" }) : track(bar.share, bar.share > 0 && bar.share < 0.005 ? "< 1 %" : `${(100 * bar.share).toFixed(0)} %`.replace("-", "−"), "share"));
}

function causeBars() {
  const bars = DATA.causes.bars;
  return h("div", { class: "bars", role: "img", "aria-label": "Probabilities and shares of the causes" },
    h("div", { class: "bar-row bar-head" }, h("div", {}, "effect"), h("div", {}, "probability"),
      h("div", {}, bars.some((b) => b.named) ? "share of what is closed" : "")),
    bars.map(barRow));
}

function parameterTable(rows, caption) {
  return table([{ title: "cause", align: "left" }, { title: "parameter", align: "left" }, { title: "value" },
    { title: "95 % interval" }, { title: "unit", align: "left" }, { title: "meaning", align: "left" }],
  rows.map((row, i) => [i && rows[i - 1][0] === row[0] ? "" : row[0], ...row.slice(1)]), { caption, class: "causes", wide: true });
}

function causesSection() {
  const causes = DATA.causes;
  const content = [];
  if (causes.bars.length) content.push(causeBars());
  if (causes.bars.some((b) => b.effects.length > 1)) content.push(h("p", { class: "note" },
    "“One of” names what this measurement cannot tell apart: one bar, one joint probability and share."
      + (DATA.next.length ? " The next scan may tell." : "")));
  // Coefficients of free shapes mean nothing one by one.
  const coefficients = causes.parameters.filter((row) => /^term_/.test(row[1]));
  const sizes = causes.parameters.filter((row) => !/^term_/.test(row[1]));
  if (sizes.length) content.push(parameterTable(sizes, "How large"));
  if (coefficients.length) content.push(h("details", {}, h("summary", {}, `${coefficients.length} coefficients of free shapes`),
    parameterTable(coefficients, null)));
  if (causes.physics.length) content.push(h("dl", { class: "physics" }, causes.physics.map(([name, text]) =>
    h("div", {}, h("dt", {}, name), h("dd", {}, text)))));
  const named = causes.bars.some((b) => b.named);
  return section("causes", named ? "Causes" : "What comes nearest", named ? null : "None of these is likely enough to be named.", content);
}

function gapFigure() {
  const choice = { unit: "percent" };
  const entry = figure("gap", "Size of the gap before, after, and at its floor", [
    chooser("Gap as", [{ value: "percent", label: "% of signal" }, { value: "g2", label: "G²" }], choice.unit,
      (v) => { choice.unit = v; entry.redraw(); })], (width) => {
    const p = palette();
    const bars = DATA.gap.bars.filter((b) => b.name !== "after" || DATA.explained);
    const values = bars.map((b) => b[choice.unit]);
    const names = { before: "before", after: "after", floor: "floor: noise alone" };
    const most = Math.max(...values.map((v) => Math.max(v.hi, v.value)), 1e-9);
    const colors = { before: isDark() ? "#f5a94d" : "#c86a06", after: p.accent, floor: p.mark };
    const percent = choice.unit === "percent";
    const data = [{ type: "bar", orientation: "h", y: bars.map((b) => names[b.name]), x: values.map((v) => v.value),
      marker: { color: bars.map((b) => withAlpha(colors[b.name], 0.8)) }, width: 0.62,
      error_x: { type: "data", symmetric: false, array: values.map((v) => v.hi - v.value),
        arrayminus: values.map((v) => v.value - v.lo), color: p.text, thickness: 1.4, width: 5 },
      customdata: values.map((v) => v.interval), hovertemplate: "%{y}: %{x:.4g} (%{customdata})<extra></extra>" }];
    const text = (v) => `<b>${v.text}${percent ? " %" : ""}</b>  <span style="color:${p.soft}">${v.interval}</span>`;
    return { data, layout: { height: 88 + 44 * bars.length, showlegend: false, margin: { l: width < 560 ? 118 : 140, r: 20, t: 8, b: 48 },
      annotations: values.map((v, i) => ({ x: Math.max(v.hi, v.value), y: names[bars[i].name], xref: "x", yref: "y", xanchor: "left",
        xshift: 10, showarrow: false, text: text(v), font: { size: 12.5, color: p.text } })),
      yaxis: axis("", { autorange: "reversed", showgrid: false, ticks: "" }),
      xaxis: axis(percent ? "gap / % of the signal" : "gap G² = mean(z²) − 1", { range: [Math.min(0, ...values.map((v) => v.lo)) * 1.1,
        most * (width < 560 ? 2.7 : 1.45)], zeroline: true }) },
      caption: ["On rows that the fit did not see. Whiskers: 95 %; before and after from rows drawn anew with replacement, "
        + "the floor from the chance of as many noise values. The floor is what not even the true model could go below.",
        DATA.explained ? ` Closed of what can be closed: ${DATA.gap.closed.text} (${DATA.gap.closed.interval}).` : ""].join("") };
  });
  return entry;
}

function signatureFigure(signature) {
  const views = [];
  if (signature.trend) views.push({ value: -1, label: signature.trend.axis === "record" ? "all records, against time" : "all records, against the signal" });
  signature.lines.forEach((line, i) => views.push({ value: i, label: line.label }));
  const choice = { view: views[0].value, rest: "refitted", unit: "sigma" };
  const unitChooser = chooser("In", UNITS, choice.unit, (v) => { choice.unit = v; entry.redraw(); });
  const showUnits = () => { unitChooser.hidden = choice.view < 0; };
  const entry = figure("signature", `Signature of ${signature.plain}`, [
    views.length > 1 ? chooser("At", views, choice.view, (v) => { choice.view = v; showUnits(); entry.redraw(); }) : null,
    chooser("The rest of the model", [{ value: "refitted", label: "fitted anew" }, { value: "held", label: "held" }], choice.rest,
      (v) => { choice.rest = v; entry.redraw(); }),
    unitChooser,
  ], (width) => buildSignature(signature, choice, width));
  showUnits();
  return entry;
}

function buildSignature(signature, choice, width) {
  const p = palette();
  const trend = choice.view < 0;
  const source = trend ? signature.trend : signature.lines[choice.view];
  const set = source[choice.rest];
  const scale = trend ? null : source.scale;
  const percent = trend || choice.unit === "percent";
  const turn = (values) => trend || !percent ? values : values.map((v, i) => (scale[i] === null ? null : v * scale[i]));
  const u = trend ? source.u : percent ? scale : source.x.map(() => 1);
  const color = trend ? p.text : wavelengthColor(source.wavelength_nm);
  const unit = percent ? "%" : "σ";
  const x = source.x;
  const axisTitle = !trend ? ANGLE_AXIS : source.axis === "record" ? "record, in the order of measurement" : "signal / V at range 1";
  const data = [{ type: "scatter", mode: "markers", x, y: turn(set.points), name: "measured less all else",
    marker: { color: p.mark, size: x.length > 120 ? 4 : 5 },
    error_y: { type: "data", array: u.map((v) => (v === null ? 0 : 1.96 * v)), color: withAlpha(p.mark, 0.4), thickness: 1, width: 0 },
    hovertemplate: `%{x:.4g}<br>%{y:.3g} ${unit}<extra></extra>` },
  { type: "scatter", mode: "lines", x, y: turn(set.line), name: signature.plain, line: { color: trend ? p.accent : color, width: 2.4 },
    hovertemplate: `%{x:.4g}<br>${signature.plain}: %{y:.3g} ${unit}<extra></extra>` }];
  const joined = trend || percent ? null : joinedPoints(x, set.points, set.line);
  if (joined) {
    delete data[0].error_y;
    data[0].marker = { color: p.mark, size: 4, opacity: 0.4 };
    data.push({ type: "scatter", mode: "markers", x: joined.map((j) => j.x), y: joined.map((j) => j.y), name: "means of neighbours",
      marker: { color: p.text, size: 7, symbol: "square" },
      error_y: { type: "data", array: joined.map((j) => j.u), color: p.text, thickness: 1.3, width: 0 },
      hovertemplate: "%{x:.4g}<br>mean %{y:.3g} σ<extra></extra>" });
  }
  const bars = joined ? ", squares: means of neighbours with 95 % bars" : ", with 95 % bars";
  // Bars of dim records must not set the scale.
  const sizes = [...turn(set.points), ...turn(set.line)].filter((v) => v !== null).map(Math.abs).sort((a, b) => a - b);
  const lineMost = Math.max(...turn(set.line).filter((v) => v !== null).map(Math.abs), 0);
  const limit = Math.max(1.15 * lineMost, 1.2 * (sizes[Math.floor(0.97 * (sizes.length - 1))] || 1));
  const xaxis = trend && source.axis === "signal"
    ? logAxis(axisTitle, Math.min(...x) / 1.3, Math.max(...x) * 1.3) : axis(axisTitle);
  const shapes = trend || source.theta_i_deg > 89 ? [] : [{ type: "line", x0: source.theta_i_deg, x1: source.theta_i_deg, y0: 0, y1: 1,
    xref: "x", yref: "paper", line: { color: p.mark, width: 1, dash: "dot" } }];
  return { data, layout: { height: 300, margin: { l: width < 560 ? 52 : 66, r: 14, t: width < 560 ? 58 : 34, b: 52 }, xaxis, shapes,
    yaxis: axis(percent ? "deviation / % of the signal" : "deviation / σ", { range: [-limit, limit], zeroline: true }) },
    caption: (choice.rest === "refitted"
      ? `Dots: what is left when ${signature.plain} is taken out and all else is fitted anew${bars}; line: what only ${signature.plain} explains of it. `
      : `Dots: what is left when ${signature.plain} is taken out and nothing else is changed${bars}; line: all that ${signature.plain} does. `)
      + (trend ? "Each dot joins neighbouring records." : "Dotted: the mirror direction.")
      + ` Without it χ² is larger by ${signature.delta_chi2}.` };
}

// Means of neighbours with their 95 % bars, where single records hide the line in their noise; else null.
function joinedPoints(x, points, line) {
  const rms = Math.sqrt(line.reduce((sum, v) => sum + v * v, 0) / line.length);
  if (x.length < 30 || rms > 2.5) return null;
  const groups = 14;
  const out = [];
  for (let g = 0; g < groups; g++) {
    const from = Math.floor((g * x.length) / groups), to = Math.floor(((g + 1) * x.length) / groups);
    const mean = (list) => list.slice(from, to).reduce((sum, v) => sum + v, 0) / (to - from);
    out.push({ x: mean(x), y: mean(points), u: 1.96 / Math.sqrt(to - from) });
  }
  return out;
}

function signaturesSection() {
  if (!DATA.signatures.length) return null;
  return section("signatures", "Signatures", "What each cause does, laid over what the simulation without it leaves.",
    DATA.signatures.map((s) => h("div", { class: "signature" },
      h("h4", {}, s.plain, s.family ? ` (${s.family})` : "", s.named ? null : h("span", { class: "role" }, "fits, but is not sure enough to be named")),
      signatureFigure(s).node)));
}

function nextSection() {
  const [best, ...others] = DATA.next;
  if (!best) {
    const ambiguous = DATA.causes.bars.some((b) => b.named && b.effects.length > 1);
    return section("next", "Take this scan next", null, h("p", {}, DATA.verdict === "unexplained"
      ? "Nothing in the catalogue explains what is seen, so no scan can be chosen to tell explanations apart. Look below where it misses."
      : ambiguous
      ? "No scan on the menu would tell apart what this one cannot."
      : "No rivals are left that a further scan would have to tell apart."));
  }
  const further = "umov scan next.toml -o next.h5";
  const again = `umov diagnose ${DATA.scans.join(" ")} next.h5 --report after.html`;
  const content = [
    h("p", { class: "next-what" }, h("b", {}, best.words.charAt(0).toUpperCase() + best.words.slice(1)), ` (${best.menu}), about ${best.minutes} min.`),
    h("p", {}, "It tells ", best.separates.map((s, i) => [i ? "; " : "", s]), `: ${best.separation} σ apart, where this scan has them together.`),
  ];
  if (DATA.plan) content.push(
    h("p", { class: "next-do" }, h("a", { class: "download", download: "next.toml",
      href: `data:text/plain;charset=utf-8,${encodeURIComponent(DATA.plan)}` }, "Save next.toml"), " then ",
      h("code", {}, further), " and ", h("code", {}, again)),
    h("details", {}, h("summary", {}, "The plan"), h("pre", { class: "plan" }, DATA.plan)));
  if (others.length) content.push(table([{ title: "or", align: "left" }, { title: "what is done", align: "left" },
    { title: "separation / σ" }, { title: "minutes" }, { title: "tells", align: "left" }],
  others.map((s) => [s.menu, s.words, s.separation, s.minutes, s.separates.join("; ")]), { class: "others" }));
  return section("next", "Take this scan next", null, content);
}
