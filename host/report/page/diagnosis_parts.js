// What the pages of all diagnoses have: verdict, places, the base model, where it comes from.

const VERDICTS = {
  none_needed: ["good", "nothing needed"], explained: ["good", "explained"], explained_in_part: ["partly", "explained in part"],
  unexplained: ["bad", "unexplained"],
};

function verdictHead() {
  const [tone, words] = VERDICTS[DATA.verdict];
  return h("header", { class: "sample-head" },
    h("h2", { class: "visually-hidden" }, "Diagnosis"),
    h("p", { class: `verdict ${tone}` }, h("span", { class: "badge" }, words), h("span", { class: "sentence" }, DATA.sentence)),
    h("dl", { class: "facts" }, DATA.facts.map((f) => h("div", {}, h("dt", {}, f.name), h("dd", {}, f.value),
      f.note ? h("dd", { class: "fact-note" }, f.note) : null))));
}

const CELL_COLUMNS = [{ title: "along", align: "left" }, { title: "from … to" }, { title: "in", align: "left" },
  { title: DATA.items }, { title: "z" }, { title: "p" }];

function whereSection() {
  const content = DATA.where.cells.length
    ? table(CELL_COLUMNS, DATA.where.cells, { caption: "Before: where the base model misses", class: "cells" })
    : h("p", {}, `Nowhere: the worst place would be as bad by chance with p = ${DATA.where.p_global}.`);
  const left = !DATA.explained ? null : DATA.left.cells.length
    ? table(CELL_COLUMNS, DATA.left.cells, { caption: `After: what is left (G² = ${DATA.left.g2} above the floor)`, class: "cells" })
    : h("p", { class: "note" }, `After: nothing significant is left (p = ${DATA.left.p_global}).`);
  return section("where", "Where it misses",
    "Places of the residual, worst first. p counts how many places were looked at: noise alone would give one as bad anywhere this often.",
    content, left);
}

function baseSection() {
  return section("base", "Base model", `What the simulation ${DATA.model} was fitted to, together with the causes.`,
    h("details", { class: "provenance" }, h("summary", {}, h("b", {}, `${DATA.base.length} parameter${DATA.base.length === 1 ? "" : "s"}`)),
      table([{ title: "parameter", align: "left" }, { title: "value" }, { title: "95 % interval" }, { title: "unit", align: "left" }],
        DATA.base)));
}

function provenanceSection() {
  return section("provenance", "Provenance", null, h("div", { class: "table-scroll wide" }, h("table", { class: "keys" },
    h("tbody", {}, DATA.provenance.map(([key, value]) => h("tr", {}, h("th", { scope: "row", class: "left" }, key),
      h("td", { class: "left" }, value)))))));
}

// `symbols`: what the letters of this page mean.
function colophon(symbols) {
  document.getElementById("colophon").append(
    h("p", {}, symbols + "G² is the mean squared residual of withheld rows in units of the noise, less one."),
    h("p", {}, `Written by ${DATA.program}. Figures by plotly.js, © 2012–2021 Plotly, Inc., MIT licence (text in the source of this page). `
      + "The page is complete in itself and asks nothing of the network."));
}

function showPage(kicker, article, symbols) {
  applyTheme();
  masthead(kicker);
  document.getElementById("main").append(article());
  contents();
  colophon(symbols);
  paintSwatches();
  watchSurroundings();
  drawAllInTurn();
}
