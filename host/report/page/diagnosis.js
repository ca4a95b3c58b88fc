// The page of a scan's diagnosis from top to bottom.

function diagnosisArticle() {
  const named = DATA.causes.bars.length > 0;
  const maps = DATA.maps.sets.map((set, i) => section(i ? "further-maps" : "maps", i ? "Residuals, further set-ups" : "Residuals",
    null, mapsFigure(set).node));
  return h("article", { id: "diagnosis", class: "sample" },
    verdictHead(),
    DATA.notes.length ? h("ul", { class: "warnings" }, DATA.notes.map((n) => h("li", {}, n))) : null,
    named ? causesSection() : null,
    section("gap", "Size of the gap", null, gapFigure().node),
    DATA.verdict === "none_needed" ? null : nextSection(),
    maps, signaturesSection(),
    section("trace", "In the order of measurement", null, traceFigure().node),
    whereSection(),
    baseSection(), provenanceSection());
}

showPage("Diagnosis of a scan", diagnosisArticle,
  "θi, θr: commanded angles of incidence and exit from the sample normal; in the plane of incidence θr is signed, positive on the mirror side. "
  + "P: electric field in the plane of incidence; S: across it; U: none in the beam. σ: standard deviation of one record with all its noise. ");
