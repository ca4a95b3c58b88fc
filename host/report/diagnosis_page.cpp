#include "host/report/diagnosis_page.hpp"

#include <fmt/format.h>

#include <cmath>

#include "host/errors/error.hpp"
#include "host/report/assets.hpp"
#include "host/report/diagnosis_parts.hpp"
#include "host/report/numbers.hpp"
#include "host/report/page_template.hpp"

namespace umov::report {

namespace {

std::string name_of(const DiagnosisInput& input) {
  if (!input.sample.empty()) return input.sample;
  return input.files.empty() ? "scan" : input.files.front();
}

/// What a reader wants to know at once, in the order of reading.
Json facts(const DiagnosisInput& input) {
  const gap::Diagnosis& d = input.diagnosis->answer;
  const gap::GapBounds& bounds = *input.diagnosis->answer.bounds;
  const auto percent = [](const char* name, const gap::GapInterval& i) {
    return Json{{"name", name},
                {"value", plain(i.percent.value, 2) + " %"},
                {"note", fmt::format("of the signal; G² = {}", plain(i.g2.value, 3))}};
  };
  const bool explained = !input.diagnosis->picture->contributions.empty();
  Json out = Json::array({percent(explained ? "gap before" : "gap", bounds.before)});
  if (explained) {
    out.push_back(percent("gap after", bounds.after));
    out.push_back(closed_fact(d));
  }
  out.push_back({{"name", "records used"},
                 {"value", count(static_cast<long long>(input.source.used))},
                 {"note", "of " + count(static_cast<long long>(input.source.records))}});
  return out;
}

std::vector<gap::Effect> declared_in(const gap::scan::Picture& picture) {
  std::vector<gap::Effect> effects;
  for (const gap::scan::Contribution& c : picture.contributions) effects.push_back(c.effect);
  if (picture.scatter) effects.push_back(*picture.scatter);
  return effects;
}

Json provenance_rows(const DiagnosisInput& input) {
  Json rows = Json::array();
  for (const std::string& file : input.files) rows.push_back({"scan", file});
  rows.push_back(
      {input.files.size() > 1 ? "sha256 of their hashes" : "sha256", input.source.sha256});
  rows.push_back(
      {"records", fmt::format("{} of {} used", input.source.used, input.source.records)});
  rows.push_back({"base model", input.source.model});
  rows.push_back({"program", "umov " + input.source.version});
  rows.push_back({"command", input.source.command});
  rows.push_back({"seed", fmt::format("{}", input.source.seed)});
  return rows;
}

}  // namespace

std::string diagnosis_data(const DiagnosisInput& input) {
  const gap::scan::ScanDiagnosis& result = *input.diagnosis;
  if (!result.picture)
    throw Error("the diagnosis was made without a picture", "ask diagnose_scans() for one");
  const gap::Diagnosis& d = result.answer;
  const gap::scan::Picture& picture = *result.picture;
  const Scene scene = scene_of(picture);
  Json data = data_of_any(d, input.source, input.created);
  data.update({{"title", name_of(input)},
               {"items", "records"},
               {"facts", facts(input)},
               {"causes", causes_json(d, declared_in(picture), picture.alternatives)},
               {"next", next_json(d)},
               {"plan", result.next_plan},
               {"scans", input.files},
               {"explained", !picture.contributions.empty()},
               {"maps", residual_maps(scene)},
               {"trace", residual_trace(scene)},
               {"signatures", signatures(scene)},
               {"provenance", provenance_rows(input)}});
  // Bytes that are no UTF-8 (from foreign headers) become replacement characters.
  return embeddable(data.dump(-1, ' ', false, Json::error_handler_t::replace));
}

std::string diagnosis_page(const DiagnosisInput& input) {
  return filled_page({"umov " + input.source.version, "Diagnosis: " + name_of(input),
                      diagnosis_data(input), assets().diagnosis});
}

}  // namespace umov::report
