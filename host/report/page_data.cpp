// All of a report's data as one JSON text.
#include <fmt/format.h>

#include <algorithm>

#include "host/formats/provenance.hpp"
#include "host/report/json_parts.hpp"
#include "host/report/numbers.hpp"
#include "host/report/page_template.hpp"
#include "host/report/report.hpp"

namespace umov::report {

namespace {

/// The line under a sample's name: instrument, date, where from.
Json meta(const Sample& sample) {
  Json out = Json::array();
  const auto put = [&](const std::string& text) {
    if (!text.empty() && std::find(out.begin(), out.end(), Json(text)) == out.end())
      out.push_back(text);
  };
  if (sample.brdf) {
    const auto& table = sample.brdf->file.table;
    const auto& made = sample.brdf->file.provenance;
    const std::string device = made.device.empty() ? key_of(table, "device") : made.device;
    put(device.empty() ? "" : "instrument: " + device);
    put(made.created.empty() ? "" : "reduced " + made.created.substr(0, 10));
    put(key_of(table, "source"));
    put(sample.brdf->source.name);
  }
  if (sample.fit) put(sample.fit->source.name);
  for (const ScanInput& scan : sample.scans) put(scan.source.name);
  return out;
}

std::vector<std::string> warnings(const SampleView& view) {
  std::vector<std::string> out = view.sample->warnings;
  if (view.fit != nullptr && !view.fit->converged)
    out.push_back("The fit did not converge; its intervals mean little.");
  if (view.table && view.table->points.size() > 0) {
    std::size_t flagged = 0;
    for (const int used : view.table->points.used) flagged += used == 0;
    const double share =
        static_cast<double>(flagged) / static_cast<double>(view.table->points.size());
    if (share > 0.1)
      out.push_back(fmt::format("{:.0f} % of the points are flagged and not used.", 100 * share));
  }
  if (view.table && view.fit != nullptr) {
    std::string missing;
    for (std::size_t w = 0; w < view.wavelengths_nm.size(); ++w)
      if (!view.fitted(w))
        missing += fmt::format("{}{} nm", missing.empty() ? "" : ", ", view.wavelengths_nm[w]);
    if (!missing.empty()) out.push_back("Measured but not fitted: " + missing + ".");
  }
  return out;
}

Json sample_json(const Sample& sample, std::size_t number) {
  const SampleView view = view_of(sample);
  Json out{{"id", fmt::format("sample-{}", number)},
           {"name", sample.name},
           {"meta", meta(sample)},
           {"warnings", warnings(view)},
           {"wavelengths_nm", rounded(view.wavelengths_nm, 6)},
           {"key", key_numbers(view)},
           {"files", provenance(sample)},
           {"directions", directions(view)}};
  const auto put = [&](const char* name, Json part) {
    if (!part.is_null()) out[name] = std::move(part);
  };
  put("brdf", brdf_curves(view));
  put("dolp", dolp_curves(view));
  put("lobe", lobe(view));
  put("residuals", residuals(view));
  put("prediction", prediction(view));
  put("fit", fit_tables(view));
  put("dhr", dhr_table(view));
  if (sample.calibration) out["calibration"] = calibration_data(*sample.calibration);
  Json scans = Json::array();
  for (const ScanInput& scan : sample.scans) scans.push_back(scan_data(scan));
  out["scans"] = std::move(scans);
  return out;
}

}  // namespace

std::string page_data(const std::vector<Sample>& samples, const Options& options) {
  Json list = Json::array();
  std::string names;
  for (const Sample& sample : samples) {
    list.push_back(sample_json(sample, list.size() + 1));
    names += (names.empty() ? "" : ", ") + sample.name;
  }
  const Json data{{"title", options.title.empty() ? names : options.title},
                  {"program", options.program},
                  {"command", options.command},
                  {"created", options.created.empty() ? formats::utc_now() : options.created},
                  {"samples", std::move(list)}};
  // Bytes that are no UTF-8 (from foreign headers) become replacement characters.
  return embeddable(data.dump(-1, ' ', false, Json::error_handler_t::replace));
}

}  // namespace umov::report
